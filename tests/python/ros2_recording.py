"""What a recorder on Fast DDS took down of a served robot, and what the simulator measured meanwhile."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from rosbags.typesys import Stores, get_typestore

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ROOT / "build/dev/tests/ros2"
STORE = get_typestore(Stores.ROS2_JAZZY)


class Served:
    """`threewe ros2 serve` in another process, inside `with`; ROS_DOMAIN_ID is the environment's."""

    def __init__(self, *options: str) -> None:
        self.options = options

    def __enter__(self) -> Served:
        program = "from threewe.cli import main; main()"
        command = [sys.executable, "-c", program, "ros2", "serve", *self.options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        assert self.process.stdout.readline().startswith("serving ")
        return self

    def __exit__(self, *exception: object) -> None:
        self.process.terminate()
        self.process.communicate(timeout=30)


def dds_type(name: str) -> str:
    """`sensor_msgs/msg/Imu` as DDS has it."""
    package, sort, kind = name.split("/")
    return f"{package}::{sort}::dds_::{kind}_"


def record(
    domain: int, file: Path, types: dict[str, str], commands: str, drive: str, *, kept: tuple[str, ...] = ()
) -> dict[str, list[Any]]:
    """Each topic's messages while the commands are driven, decoded by rosbags; `drive` is an option and a topic."""
    topics = [f"{topic}={dds_type(name)}{'!' if topic in kept else ''}" for topic, name in types.items()]
    command = [str(PROGRAMS / "ros2_recorder"), str(domain), str(file), *drive.split(), *topics]
    done = subprocess.run(command, input=commands, capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.returncode) == ("ready\n", 0), done
    messages: dict[str, list[Any]] = {topic: [] for topic in types}
    rest = file.read_bytes()
    while rest:
        head, _, rest = rest.partition(b"\n")
        topic, size = head.decode().split()
        messages[topic].append(STORE.deserialize_cdr(rest[: int(size)], types[topic]))
        rest = rest[int(size) :]
    return messages


def simulate(scene: str, profile: str, seed: int, commands: str) -> dict[str, list[Any]]:
    """Each sensor's samples while the same commands are driven: when they were measured [ns], and their values."""
    command = [str(PROGRAMS / "ros2_samples"), scene, profile, str(seed)]
    done = subprocess.run(command, input=commands, capture_output=True, text=True, check=True)
    samples: dict[str, list[Any]] = {}
    for line in done.stdout.splitlines():
        sample = json.loads(line)
        samples.setdefault(sample["sensor"], []).append((sample["measured"], sample["values"]))
    return samples
