"""Demonstrations of `goto`: the navigator drives to things that are in view, and instructions name them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from threewe._core import Pose2D, Scene
from threewe.data.exporting import export
from threewe.data.recorder import TrajectoryRecorder
from threewe.data.recording import Recording
from threewe.errors import ConfigError
from threewe.robot import Robot
from threewe.simulation import Simulation

IMAGE = (48, 64)
"""(height, width) [px] of what is recorded"""
FPS = 10
PER_SCENE = 10
NEAREST, FARTHEST = 1.5, 5.0  # [m] from the robot to a thing
IN_VIEW = math.radians(35)  # of the camera's axis, at most
SHOWN = 0.002  # of the picture that shows it, at least
STANDS_FROM = (0.8, 1.0, 1.2, 1.4)  # [m] from a thing's centre to where the robot stops
STANDS_FOR = 1.0  # [s] that are recorded in the end
TRIES = 2000


async def collect_goto(output: Path, episodes: int, scene: str, backend: str, hardware: str, seed: int) -> int:
    """Writes a LeRobot dataset of `episodes` drives; how many arrived. `scene` may be `procedural`."""
    if output.exists():
        raise ConfigError(f"output: {output} exists already")
    arrived = 0
    with TemporaryDirectory() as folder:
        journals = Path(folder, "journals")
        for begin, path in zip(range(0, episodes, PER_SCENE), _scenes(scene, seed, Path(folder)), strict=False):
            count = min(PER_SCENE, episodes - begin)
            arrived += await _collect_in(path, count, backend, hardware, seed + begin, journals)
        export(Recording(journals), output, format="lerobot", fps=FPS)
    return arrived


def _scenes(scene: str, seed: int, folder: Path) -> Iterator[str]:
    if scene != "procedural":
        while True:
            yield scene
    number = seed * 100_003
    while True:
        number += 1
        path = folder / f"building_{number}.yaml"
        path.write_text(Scene.generate(number, difficulty=(number % 5) / 5).to_yaml(path.stem), encoding="utf-8")
        yield str(path)


async def _collect_in(scene: str, count: int, backend: str, hardware: str, seed: int, journals: Path) -> int:
    arrived = 0
    robot = Robot(backend, hardware, scene, seed=seed, localization="truth", image_size=IMAGE)
    async with robot:
        assert robot.simulation is not None
        random = np.random.default_rng(seed)
        with TrajectoryRecorder(robot, journals) as recorder:
            for episode in range(count):
                category, start, goal = _task(robot.simulation, random)
                robot.simulation.reset(seed=seed, episode=episode, pose=start)
                there = robot.simulation.scene_from_map.inverse() * goal
                recorder.start_episode(f"go to the {category}")
                result = await robot.move_to(there.x, there.y, there.theta, timeout=60.0)
                await robot.sleep(STANDS_FOR)
                recorder.end_episode(success=result.success, metadata={"reason": str(result.reason)})
                arrived += result.success
    return arrived


def _task(simulation: Simulation, random: np.random.Generator) -> tuple[str, Pose2D, Pose2D]:
    """What a thing is called that is in view of a free pose, that pose, and where to stop before it."""
    things = list(simulation.scene.objects)
    for _ in range(TRIES):
        start = simulation.sample_free_pose(int(random.integers(1 << 31)))
        near = [thing for thing in things if _in_view(start, thing.pose)]
        if not near:
            continue
        thing = near[int(random.integers(len(near)))]
        picture = simulation.look(pose=start)
        if thing.name not in picture.names:
            continue
        if np.mean(picture.ids == list(picture.names).index(thing.name)) < SHOWN:
            continue
        away = math.atan2(start.y - thing.pose.y, start.x - thing.pose.x)
        for distance in STANDS_FROM:
            x, y = thing.pose.x + distance * math.cos(away), thing.pose.y + distance * math.sin(away)
            goal = Pose2D(x, y, math.atan2(-math.sin(away), -math.cos(away)))
            if simulation.geodesic(start, goal) < 1.5 * FARTHEST:
                return thing.category, start, goal
    raise ConfigError(f"scene: nothing is in view {NEAREST:g} to {FARTHEST:g} m away from any of {TRIES} free poses")


def _in_view(robot: Pose2D, thing: Pose2D) -> bool:
    dx, dy = thing.x - robot.x, thing.y - robot.y
    bearing = math.remainder(math.atan2(dy, dx) - robot.theta, 2 * math.pi)
    return NEAREST <= math.hypot(dx, dy) <= FARTHEST and abs(bearing) < IN_VIEW
