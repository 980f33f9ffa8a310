"""LeRobot in a process of its own, which answers what it is asked."""

import json
import os
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

Ask = Callable[..., dict[str, Any]]


@contextmanager
def peer_of(script: str) -> Iterator[Ask]:
    """Runs a script of this folder in LeRobot's Python."""
    words = [os.environ["LEROBOT_PYTHON"], str(Path(__file__).with_name(script))]
    peer = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert peer.stdin is not None
    assert peer.stdout is not None
    send, receive = peer.stdin, peer.stdout

    def ask(do: str, **arguments: Any) -> dict[str, Any]:
        paths = {name: str(value) if isinstance(value, Path) else value for name, value in arguments.items()}
        send.write(json.dumps({"do": do, **paths}) + "\n")
        send.flush()
        line = next(line for line in receive if line.startswith("@"))
        reply = json.loads(line[1:])
        assert "error" not in reply, reply["error"]
        return dict(reply["answer"])

    with peer:
        yield ask
        send.close()
