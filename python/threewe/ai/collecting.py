"""Demonstrations of `goto`: the navigator drives to things that are in view, and instructions name them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from threewe._core import MoveResult, Object, ObjectNav, Pose2D, RobotProfile, SceneTables
from threewe.benchmark.buildings import building_name, scene_asset
from threewe.data.exporting import export
from threewe.data.recorder import TrajectoryRecorder
from threewe.data.recording import DISTURBED, Recording, spans_to_text
from threewe.errors import ConfigError
from threewe.robot import Robot
from threewe.simulation import Simulation

IMAGE = (60, 80)
"""(height, width) [px] of what is recorded"""
FPS = 10
PER_SCENE = 10
STANDS_FROM = (0.55, 0.7, 0.85)  # [m] from a thing's nearest side to where the robot stops, the first that shows it
TURNS = (0.0, 0.35, -0.35, 0.7, -0.7)  # [rad] about the thing, from the straight way to it
SHOWN = 0.002  # of the picture, at least, that shows it in the end
ROOM = 0.08  # [m] around the robot there, whichever way it turns
LONGEST = 12.0  # [m] of the way
STANDS_FOR = 1.0  # [s] that are recorded in the end
LIMIT = 60.0  # [s] of a drive
TRIES = 200
CALM = (0.5, 5.0)  # [s] before a burst of random commands
BURST = (0.4, 1.6)  # [s] that it lasts
BURSTS = 3  # of a drive, at most


@dataclass(frozen=True)
class Collection:
    """How demonstrations are made."""

    scene: str = "procedural"
    """a name, a file, or `procedural`: generated buildings of all sizes, ten drives each"""
    backend: str = "mock"
    hardware: str = "3we_standard_v2"
    randomization: str = "none"
    bursts: bool = True
    """random commands push the robot off its way, and the dataset marks them as `disturbed`"""
    seed: int = 0


async def collect_goto(output: Path, episodes: int, how: Collection) -> int:
    """Writes a LeRobot dataset of `episodes` drives; how many arrived. Raises ConfigError."""
    if output.exists():
        raise ConfigError(f"output: {output} exists already")
    done = arrived = 0
    with TemporaryDirectory() as folder:
        for number, scene in enumerate(_scenes(how)):
            drives = await _collect_in(scene, min(PER_SCENE, episodes - done), how, number, Path(folder))
            done, arrived = done + len(drives), arrived + sum(drives)
            if done == episodes:
                break
            if done == 0 and number == TRIES:
                raise ConfigError(f"scene: nothing is in sight from any of many places in {scene}")
        export(Recording(folder), output, format="lerobot", fps=FPS)
    return arrived


def _scenes(how: Collection) -> Iterator[str]:
    for number in count():
        procedural = how.scene == "procedural"
        yield scene_asset(building_name(f"collect/{how.seed}/{number}")) if procedural else how.scene


async def _collect_in(scene: str, episodes: int, how: Collection, number: int, journals: Path) -> list[bool]:
    """Whether each drive arrived; there are fewer where the scene has too few tasks."""
    seed = how.seed * 100_003 + number
    random = np.random.default_rng(seed)
    profile = RobotProfile.load(how.hardware)
    robot = Robot(
        how.backend,
        how.hardware,
        scene,
        seed=seed,
        localization="truth",
        image_size=IMAGE,
        randomization=how.randomization,
    )
    drives: list[bool] = []
    async with robot:
        assert robot.simulation is not None
        try:
            tables = SceneTables(robot.simulation.scene, profile)
            task = ObjectNav(tables, profile)
            kinds = [kind for kind in task.goals if kind != "door"]
        except ConfigError:  # nothing there can be looked for
            return []
        with TrajectoryRecorder(robot, journals, sensors=["camera"]) as recorder:
            for index in range(3 * episodes):
                if len(drives) == episodes or not kinds:
                    break
                kind = kinds[int(random.integers(len(kinds)))]
                try:
                    start = task.sample_in_sight(seed, index, kind).start
                except ConfigError:
                    kinds.remove(kind)
                    continue
                robot.simulation.reset(seed=seed, episode=index, pose=start)
                goal = _goal(robot.simulation, tables, profile, kind)
                if goal is None:
                    continue
                there = robot.simulation.scene_from_map.inverse() * goal
                recorder.start_episode(f"go to the {kind}")
                result, disturbed = await _drive(robot, there, random if how.bursts else None)
                await robot.sleep(STANDS_FOR)
                kept = {"reason": str(result.reason), DISTURBED: spans_to_text(disturbed)}
                recorder.end_episode(success=result.success, metadata=kept)
                drives.append(result.success)
    return drives


async def _drive(
    robot: Robot, goal: Pose2D, random: np.random.Generator | None
) -> tuple[MoveResult, list[tuple[float, float]]]:
    """To a goal, and when random commands pushed the robot on its way [s]."""
    disturbed: list[tuple[float, float]] = []
    for _ in range(0 if random is None else int(random.integers(BURSTS + 1))):
        assert random is not None
        until = robot.now + random.uniform(*CALM)
        result = await robot.move_to(goal.x, goal.y, goal.theta, timeout=until - robot.now)
        if result.reason != "timeout":
            return result, disturbed
        seconds = random.uniform(*BURST)
        limits = robot.profile.operating_limits
        vx, vy = random.uniform(-0.6, 1.0) * limits.linear, random.uniform(-0.8, 0.8) * limits.linear
        sideways = robot.profile.kinematics.name == "holonomic"
        robot.set_velocity(vx, vy if sideways else 0.0, random.uniform(-1.0, 1.0) * limits.angular, hold=seconds)
        await robot.sleep(seconds)
        disturbed.append((until, robot.now))  # braking was no wish of the navigator either
    return await robot.move_to(goal.x, goal.y, goal.theta, timeout=LIMIT), disturbed


def _goal(simulation: Simulation, tables: SceneTables, profile: RobotProfile, kind: str) -> Pose2D | None:
    """Where to stop before the thing of a kind that is seen best: near it, turned to it, and so that it is seen."""
    start, seen = simulation.true_pose(), simulation.look()
    pixels = {name: int(np.sum(seen.ids == i)) for i, name in enumerate(seen.names)}
    things = [thing for thing in simulation.scene.objects if thing.category == kind]
    thing = max(things, key=lambda one: pixels.get(one.name, 0))
    assert profile.camera is not None
    away = math.atan2(start.y - thing.pose.y, start.x - thing.pose.x)
    for near in STANDS_FROM:
        for turn in TURNS:
            goal = _before(thing, away + turn, near)
            if not simulation.geodesic(start, goal) < LONGEST or _room(tables, goal) < ROOM:
                continue
            picture = simulation.look(pose=goal * profile.camera.base_from_camera, with_itself=False)
            if np.mean(picture.ids == list(picture.names).index(thing.name)) >= SHOWN:
                return goal
    return None


def _room(tables: SceneTables, place: Pose2D) -> float:
    """[m] to the nearest obstacle, in the worst of sixteen headings."""
    return min(tables.clearance(Pose2D(place.x, place.y, k * math.pi / 8)) for k in range(16))


def _before(thing: Object, direction: float, near: float) -> Pose2D:
    """The pose so far [m] from a thing's nearest side, in a direction from its middle, turned to it."""
    cosine, sine = math.cos(direction), math.sin(direction)
    corners = [thing.pose * Pose2D(x, y, 0.0) for prism in thing.prisms for x, y in prism.outline()]
    outer = max((c.x - thing.pose.x) * cosine + (c.y - thing.pose.y) * sine for c in corners)
    radius = outer + near
    return Pose2D(thing.pose.x + radius * cosine, thing.pose.y + radius * sine, math.atan2(-sine, -cosine))
