"""openpi's client at work, in its own Python: asks the server at an address for the actions of given observations.

Arguments: address, observations (`number/name` in an .npz file), text, output (.npz). It knows nothing of 3we.
"""

import sys

import numpy as np
from openpi_client.websocket_client_policy import WebsocketClientPolicy

address, given, prompt, out = sys.argv[1:]
client = WebsocketClientPolicy(address)
found = {}
with np.load(given) as arrays:
    for i in range(1 + max(int(key.split("/")[0]) for key in arrays.files)):
        own = {key.split("/", 1)[1]: arrays[key] for key in arrays.files if key.startswith(f"{i}/")}
        found[str(i)] = client.infer({**own, "prompt": prompt})["actions"]
np.savez(out, **found)
print(client.get_server_metadata()["format"])
