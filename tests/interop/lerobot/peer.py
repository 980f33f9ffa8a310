"""LeRobot 0.6.1 at work: loads and writes datasets as it is asked to, in its own Python. It knows nothing of 3we.

Each line on its input is a JSON object with `do` and arguments; it ends its answer with a line that begins with @.
"""

import json
import os
import sys
import time
import traceback
from pathlib import Path

os.environ["HF_HUB_OFFLINE"] = "1"  # whatever would be downloaded, fails

import numpy as np

from lerobot.datasets.lerobot_dataset import LeRobotDataset


def load(root, arrays, deltas):
    """Every frame, alone and with its neighbours in time; all values go into an .npz file."""
    dataset = LeRobotDataset("local/ours", root=root)
    frames = [dataset[i] for i in range(len(dataset))]
    kept = {key: stacked([frame[key] for frame in frames]) for key in frames[0]}
    around = LeRobotDataset("local/ours", root=root, delta_timestamps=deltas)
    frames = [around[i] for i in range(len(around))]
    for key in deltas:
        kept[f"delta/{key}"] = stacked([frame[key] for frame in frames])
        kept[f"pad/{key}"] = stacked([frame[f"{key}_is_pad"] for frame in frames])
    np.savez(arrays, **kept)
    stats = {key: {name: value.tolist() for name, value in each.items()} for key, each in dataset.meta.stats.items()}
    return {"frames": len(dataset), "episodes": dataset.num_episodes, "stats": stats}


def stacked(values):
    if isinstance(values[0], str):
        return np.array(values)
    return np.stack([np.asarray(value) for value in values])


def write(root, arrays, features, fps, tasks, robot_type, streaming=False):
    """A dataset of its own, at its defaults; seconds from the first frame to the last file."""
    for feature in features.values():
        feature["shape"] = tuple(feature["shape"])
    options = {"streaming_encoding": True} if streaming else {}
    dataset = LeRobotDataset.create("local/theirs", fps, features, root=root, robot_type=robot_type, **options)
    return {"seconds": record(dataset, np.load(arrays, allow_pickle=False), tasks)}


def resume(root, arrays, tasks):
    """More episodes in a dataset that exists."""
    dataset = LeRobotDataset.resume("local/ours", root=root)
    return {"seconds": record(dataset, np.load(arrays, allow_pickle=False), tasks)}


def record(dataset, given, tasks):
    own = [key for key in dataset.meta.features if f"0/{key}" in given]
    episodes = [{key: given[f"{i}/{key}"] for key in own} for i in range(len(tasks))]
    began = time.perf_counter()
    for task, episode in zip(tasks, episodes, strict=True):
        for i in range(len(episode[own[0]])):
            frame = {key: as_frame(values[i], dataset.meta.features[key]) for key, values in episode.items()}
            dataset.add_frame({**frame, "task": task})
        dataset.save_episode()
    dataset.finalize()
    return time.perf_counter() - began


def as_frame(value, feature):
    if feature["dtype"] == "string":
        return str(value)
    return np.asarray(value).reshape(feature["shape"])


def train(root, output, steps):
    """ACT by LeRobot's own program."""
    import subprocess

    words = [
        *("--policy.type=act", "--policy.pretrained_backbone_weights=null", "--policy.device=cpu"),
        *("--policy.push_to_hub=false", "--policy.dim_model=64", "--policy.n_heads=4", "--policy.dim_feedforward=128"),
        *(
            "--policy.chunk_size=5",
            "--policy.n_action_steps=5",
            f"--dataset.root={root}",
            "--dataset.repo_id=local/ours",
        ),
        *(f"--output_dir={output}", f"--steps={steps}", "--batch_size=4", "--num_workers=0", f"--save_freq={steps}"),
        *("--log_freq=1", "--wandb.enable=false"),
    ]
    program = Path(sys.executable).parent / "lerobot-train"
    done = subprocess.run([program, *words], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stdout[-2000:] + done.stderr[-4000:])
    return {
        "checkpoints": sorted(path.name for path in Path(output).rglob("model.safetensors")),
        "log": done.stderr[-3000:],
    }


def convert(root):
    """A dataset in version 2.1 to 3.0, in place, by LeRobot's own program."""
    from lerobot.scripts.convert_dataset_v21_to_v30 import convert_dataset

    convert_dataset("local/ours", root=root, push_to_hub=False)
    return {}


def main():
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = {
                "answer": {"load": load, "write": write, "resume": resume, "train": train, "convert": convert}[
                    request.pop("do")
                ](**request)
            }
        except Exception:
            answer = {"error": traceback.format_exc()}
        print("\n@" + json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
