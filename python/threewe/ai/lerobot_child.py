"""Program of a child process in LeRobot's own Python: loads a checkpoint and answers observations with actions.

Its source is passed to that interpreter, which knows nothing of 3we. A message is a line of JSON and, after it, arrays
as plain bytes: from the parent `{"arrays": {name: [dtype, shape]}, "task": ...}`, back `{"arrays": {"action": ...}}` or
`{"error": ...}`.
"""

# mypy: ignore-errors

import json
import os
import sys

sys.path[:] = [path for path in sys.path if path]  # nothing is imported from the folder that it runs in
PIPE = os.fdopen(os.dup(1), "wb")
os.dup2(2, 1)  # what libraries print goes elsewhere


def send(content, data=b""):
    """One message."""
    PIPE.write(json.dumps(content).encode() + b"\n" + data)
    PIPE.flush()


def receive():
    """One message; None when the parent has gone."""
    import numpy as np

    line = sys.stdin.buffer.readline()
    if not line:
        return None
    content = json.loads(line)
    arrays = {}
    for name, (kind, shape) in content["arrays"].items():
        count = int(np.prod(shape)) * np.dtype(kind).itemsize
        arrays[name] = np.frombuffer(sys.stdin.buffer.read(count), kind).reshape(shape).copy()
    return arrays, content["task"]


def main(folder):
    """Loads, says so, and answers until the parent goes."""
    try:
        import torch
        from lerobot.configs.policies import PreTrainedConfig
        from lerobot.policies.factory import get_policy_class, make_pre_post_processors
    except ImportError as error:
        send({"missing": str(error)})
        return
    try:
        torch.set_num_threads(max(1, (os.cpu_count() or 2) - 1))
        config = PreTrainedConfig.from_pretrained(folder)
        policy = get_policy_class(config.type).from_pretrained(folder, config=config).eval()
        device = {"device_processor": {"device": str(config.device)}}
        before, after = make_pre_post_processors(config, pretrained_path=folder, preprocessor_overrides=device)
    except Exception as error:
        send({"error": f"{type(error).__name__}: {error}"})
        return
    send({"ready": True})
    while (message := receive()) is not None:
        arrays, task = message
        try:
            batch = before({**{name: torch.from_numpy(each) for name, each in arrays.items()}, "task": [task]})
            steps = getattr(config, "n_obs_steps", 1)
            if steps > 1:  # an observation stands for those before it
                for name in arrays:
                    batch[name] = torch.stack([batch[name]] * steps, 1)
            batch.setdefault("observation.state", torch.zeros(1, 1))  # ACT asks it for its device
            torch.manual_seed(0)  # the same observation gives the same actions
            with torch.inference_mode():
                actions = after(policy.predict_action_chunk(batch)).float().cpu().numpy()
            send({"arrays": {"action": ["<f4", list(actions.shape)]}}, actions.astype("<f4").tobytes())
        except Exception as error:
            send({"error": f"{type(error).__name__}: {error}"})


if __name__ == "__main__":
    main(sys.argv[1])
