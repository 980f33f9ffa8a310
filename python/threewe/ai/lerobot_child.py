"""Program of a child process in LeRobot's own Python: loads a checkpoint and answers observations with actions.

Its source is passed to that interpreter, which knows nothing of 3we. A message is a line of JSON and, after it, arrays
as plain bytes: from the parent `{"arrays": {name: [dtype, shape]}, "task": ...}`, back `{"arrays": {"action": ...}}` or
`{"error": ...}`. `action.prefix` has the first actions of the chunk that are committed, with a 1 after their numbers.
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
        import lerobot.policies.factory  # noqa: F401
    except ImportError as error:
        send({"missing": str(error)})
        return
    try:
        checkpoint = Checkpoint(folder)
    except Exception as error:
        send({"error": f"{type(error).__name__}: {error}"})
        return
    send({"ready": True, "rtc": checkpoint.rtc})
    while (message := receive()) is not None:
        try:
            actions = checkpoint.actions(*message)
            send({"arrays": {"action": ["<f4", list(actions.shape)]}}, actions.astype("<f4").tobytes())
        except Exception as error:
            send({"error": f"{type(error).__name__}: {error}"})


class Checkpoint:
    """A policy with its processors."""

    def __init__(self, folder):
        import torch
        from lerobot.configs.policies import PreTrainedConfig
        from lerobot.policies.factory import get_policy_class, make_pre_post_processors

        torch.set_num_threads(max(1, (os.cpu_count() or 2) - 1))
        self.config = config = PreTrainedConfig.from_pretrained(folder)
        self.policy = get_policy_class(config.type).from_pretrained(folder, config=config).eval()
        device = {"device_processor": {"device": str(config.device)}}
        self.before, self.after = make_pre_post_processors(
            config, pretrained_path=folder, preprocessor_overrides=device
        )
        self.rtc = bool(getattr(getattr(config, "rtc_config", None), "enabled", False))
        if self.rtc and not self.policy.supports_rtc():
            raise ValueError(f"rtc_config: '{config.type}' has no real-time chunking")

    def actions(self, arrays, task):
        """(1, chunk, numbers) in the policy's units."""
        import torch

        prefix = arrays.pop("action.prefix", None)
        given = {name: torch.from_numpy(each) for name, each in arrays.items()}
        count = 0 if prefix is None else int(prefix[0, :, -1].sum())
        if count > 0:  # normalised with the observation, and relative to its state where the policy's actions are
            given["action"] = torch.from_numpy(prefix[:, :count, :-1])
        batch = self.before({**given, "task": [task]})
        committed = batch.pop("action", None)
        steps = getattr(self.config, "n_obs_steps", 1)
        if steps > 1:  # an observation stands for those before it
            for name in arrays:
                batch[name] = torch.stack([batch[name]] * steps, 1)
        batch.setdefault("observation.state", torch.zeros(1, 1))  # ACT asks it for its device
        options = {}
        if count > 0:
            options = {"prev_chunk_left_over": committed, "inference_delay": count, "execution_horizon": count}
        torch.manual_seed(0)  # the same observation gives the same actions
        with torch.no_grad():  # not inference_mode, in which real-time chunking has no gradients
            return self.after(self.policy.predict_action_chunk(batch, **options)).float().cpu().numpy()


if __name__ == "__main__":
    main(sys.argv[1])
