"""Episodes with video exported to a LeRobot dataset, beside LeRobot's own writer at its defaults on the same frames.

    ./dev interop lerobot        # once: installs LeRobot in build/interop/lerobot
    .venv/bin/python benchmarks/record/lerobot_export.py [--episodes 20] [--steps 250]

A robot drives through `office_v2`; its camera's frames are H.264 key frames, as a recorder has them. Ours copies the
packets ("copy"), or decodes them and encodes AV1 at LeRobot's settings ("av1"). LeRobot gets the decoded frames one by
one, which takes none of its time: `add_frame` (PNG files), `save_episode` (statistics, AV1) and `finalize` are counted.
Both use all CPUs.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import threewe.sync
from threewe.data.lerobot import DatasetWriter, PacketFrames, validate
from threewe.data.video import KeyFrameEncoder

ROOT = Path(__file__).resolve().parents[2]
PEER = ROOT / "build/interop/lerobot/bin/python"
SHAPE, FPS, CAMERA = (480, 640, 3), 10, "observation.images.front"
FEATURES: dict[str, dict[str, Any]] = {
    "observation.state": {"dtype": "float32", "shape": [3], "names": ["x", "y", "theta"]},
    "action": {"dtype": "float32", "shape": [3], "names": ["vx", "vy", "omega"]},
    CAMERA: {"dtype": "video", "shape": list(SHAPE), "names": ["height", "width", "channels"]},
}
Episode = tuple[dict[str, Any], list[bytes]]


def main() -> int:
    """Prints seconds, sizes and ratios."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--steps", type=int, default=250)
    parser.add_argument("--out", type=Path, help="JSON of the figures")
    options = parser.parse_args()
    episodes = [drive(seed, options.steps) for seed in range(options.episodes)]
    results: dict[str, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as place:
        for codec in ("copy", "av1"):
            results[codec] = ours(Path(place) / codec, codec, episodes)
        if PEER.exists():
            results["LeRobot"] = theirs(Path(place), episodes)
        else:
            print("LeRobot is not installed: ./dev interop lerobot installs it")
    for name, result in results.items():
        print(f"{name:8} {result['seconds']:7.1f} s {result['megabytes']:8.1f} MB")
    if peer := results.get("LeRobot"):
        print(f"         of LeRobot's, {peer['saving']:.1f} s are save_episode and finalize alone")
        for codec in ("copy", "av1"):
            faster, size = peer["seconds"] / results[codec]["seconds"], results[codec]["video_megabytes"]
            alone = peer["saving"] / results[codec]["seconds"]
            share = f"{size / peer['video_megabytes']:.3f} of its video size"
            print(f"{codec}: {faster:.2f} x as fast as LeRobot ({alone:.2f} x without its add_frame), {share}")
    if options.out:
        options.out.write_text(json.dumps(results, indent=1))
    return 0


def drive(seed: int, steps: int) -> Episode:
    """Columns and encoded frames of a robot that turns and drives at will."""
    rng = np.random.default_rng(seed)
    encoder = KeyFrameEncoder(SHAPE, "rgb24")
    packets, states, actions = [], [], []
    with threewe.sync.Robot(scene="office_v2", seed=seed) as robot:
        action = np.zeros(3)
        for step in range(steps):
            if step % 15 == 0:
                action = rng.uniform((-0.1, -0.1, -0.8), (0.4, 0.1, 0.8))
            robot.set_velocity(*action)
            robot.sleep(1 / FPS)
            packets.append(encoder.encode(robot.get_camera_image()[..., ::-1]))
            pose = robot.get_pose()
            states.append((pose.x, pose.y, pose.theta))
            actions.append(action)
    return {"observation.state": np.array(states, np.float32), "action": np.array(actions, np.float32)}, packets


def ours(root: Path, codec: Any, episodes: list[Episode]) -> dict[str, float]:
    """Seconds and size of our dataset, which must be sound."""
    began = time.perf_counter()
    with DatasetWriter(root, fps=FPS, features=FEATURES, robot_type="3we_standard_v2", codec=codec) as writer:
        for columns, packets in episodes:
            writer.add_episode(columns, "look around", {CAMERA: PacketFrames(packets, SHAPE)})
    seconds = time.perf_counter() - began
    problems = validate(root)
    assert not problems, problems[:3]
    return {"seconds": seconds, **sizes(root)}


def theirs(place: Path, episodes: list[Episode]) -> dict[str, float]:
    """Seconds and size of LeRobot's dataset."""
    for i, (columns, packets) in enumerate(episodes):
        lengths = np.array([len(packet) for packet in packets])
        np.savez(place / f"{i}.npz", lengths=lengths, packets=np.frombuffer(b"".join(packets), np.uint8), **columns)
    request = {"place": str(place), "episodes": len(episodes), "features": FEATURES, "fps": FPS, "camera": CAMERA}
    words = [str(PEER), str(Path(__file__).with_name("lerobot_peer.py")), json.dumps(request)]
    done = subprocess.run(words, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return {**json.loads(done.stdout.strip().splitlines()[-1]), **sizes(place / "theirs")}


def sizes(root: Path) -> dict[str, float]:
    """[MB] of all files, and of videos."""
    files = [path for path in root.rglob("*") if path.is_file()]
    videos = sum(path.stat().st_size for path in files if path.suffix == ".mp4")
    return {"megabytes": sum(path.stat().st_size for path in files) / 1e6, "video_megabytes": videos / 1e6}


if __name__ == "__main__":
    raise SystemExit(main())
