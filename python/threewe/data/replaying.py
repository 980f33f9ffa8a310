"""Replays of recorded actions: in the recorded world made anew, bit by bit, or by a robot on any backend."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from threewe._core import Pose2D, RobotProfile, profile_names
from threewe.data.export_lerobot import VELOCITY
from threewe.data.exporting import has_ticks
from threewe.data.recording import RecordedEpisode, Recording
from threewe.errors import ConfigError
from threewe.robot import Robot

SETTLE = 0.2
"""[s] that a command may take to become motion, at the end."""


def replay_all(path: Path, backend: str | None, scene: str, only: int | None) -> Iterator[tuple[str, bool]]:
    """A line about each episode, and whether it was as recorded."""
    if (path / "meta").is_dir():
        yield from _replay_dataset(path, backend or "mock", scene, only)
        return
    recording = Recording(path)
    places = [place for place, number in enumerate(recording.numbers) if only is None or number == only]
    if not places:
        raise ConfigError(f"{path}: has no episode {only}")
    for episode in filter(has_ticks, (recording[place] for place in places)):
        if backend is None:
            if episode.robot == 0:  # all robots of a world at once
                yield _as_recorded(episode)
        else:
            with _hardware(episode) as hardware:
                end, driven = asyncio.run(drive(episode.executed, episode.control_rate, backend, hardware, scene))
            recorded = Pose2D(*episode.pose[-1]), Pose2D(*episode.pose[0])
            yield _line(f"episode {episode.index}", *recorded, end, driven), True


@contextmanager
def _hardware(episode: RecordedEpisode) -> Iterator[str]:
    """The name of the robot's profile; where that means another robot by now, or none, a file as it was recorded."""
    name = episode.robot_type
    if not episode.hardware or (name in profile_names() and RobotProfile.load(name).yaml == episode.hardware):
        yield name
        return
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"{name}.yaml"
        file.write_text(episode.hardware, encoding="utf-8")
        yield str(file)


def _as_recorded(episode: RecordedEpisode) -> tuple[str, bool]:
    report = episode.replay()
    same = report.first_difference is None
    what = "the same to the bit" if same else f"differs from {report.first_difference:.2f} s on"
    return f"episode {episode.index}: {report.ticks} ticks, {report.max_deviation:.6f} m apart, {what}", same


def _replay_dataset(path: Path, backend: str, scene: str, only: int | None) -> Iterator[tuple[str, bool]]:
    """Of an exported dataset: its `action` column."""
    from threewe.data.lerobot import Dataset

    dataset = Dataset.open(path)
    names = dataset.features["action"].names if "action" in dataset.features else None
    if names not in (VELOCITY, ["vx", "omega"]):
        raise ConfigError(f"{path}: has no `action` of vx, vy [m/s] and omega [rad/s]; 3we cannot drive by it")
    state = dataset.features.get("observation.state")
    if state is None or not isinstance(state.names, list) or state.names[:3] != ["x", "y", "theta"]:
        raise ConfigError(
            f"{path}: has no `observation.state` of x, y [m] and theta [rad]: there is nothing to compare"
        )
    chosen = [episode for episode in dataset.episodes if only is None or episode.index == only]
    if not chosen:
        raise ConfigError(f"{path}: has no episode {only}")
    axes = [VELOCITY.index(name) for name in names]
    for episode in chosen:
        columns = episode.columns()
        actions = np.zeros((len(columns["action"]), len(VELOCITY)))
        actions[:, axes] = columns["action"]
        poses = columns["observation.state"][:, :3].astype(float)
        hardware = dataset.info.robot_type or "3we_standard_v2"
        end, driven = asyncio.run(drive(actions, dataset.info.fps, backend, hardware, scene))
        recorded = Pose2D(*poses[-1]), Pose2D(*poses[0])
        yield _line(f"episode {episode.index}", *recorded, end, driven), True


def _line(name: str, end: Pose2D, start: Pose2D, replayed: Pose2D, driven: float) -> str:
    """How far apart the ends are, each seen from where it began."""
    apart = (start.inverse() * end).distance(replayed)
    return (
        f"{name}: ends {apart:.3f} m from where it was recorded to end, after {driven:.2f} m, by the robot's own poses"
    )


async def drive(
    actions: NDArray[np.floating], rate: float, backend: str, hardware: str, scene: str
) -> tuple[Pose2D, float]:
    """Drives (N, 3) velocities [m/s, m/s, rad/s] at a rate [Hz]; the safety gate stays in charge.

    Returns where the robot ends, seen from where it began, and how far it has driven [m].
    """
    async with Robot(backend=backend, hardware=hardware, scene=scene) as robot:
        start = last = robot.get_pose()
        driven = 0.0
        begun = robot.now
        for number, action in enumerate(actions.tolist(), 1):
            robot.set_velocity(*action, hold=1.5 / rate)
            await robot.sleep(max(0.0, begun + number / rate - robot.now))
            driven += robot.get_pose().distance(last)
            last = robot.get_pose()
        robot.stop()
        await robot.sleep(SETTLE)
        return start.inverse() * robot.get_pose(), driven
