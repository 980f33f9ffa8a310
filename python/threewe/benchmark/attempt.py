"""One episode: an agent drives it, and the truth says what came of that."""

from __future__ import annotations

import asyncio
import base64
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import (
    DriveLog,
    OccupancyGrid,
    Pose2D,
    Replay,
    RobotEnv,
    RobotOptions,
    TrueDrive,
    places_of_scene,
)
from threewe.backend import known_backend
from threewe.benchmark.agents import InstructedByModel, make_agent
from threewe.benchmark.buildings import load_scene, scene_asset
from threewe.benchmark.episodes import Episode, Yardstick
from threewe.benchmark.tasks import SCENES_KEPT, TASKS, TICK, Assignment, Metrics, Place, Task, place_of, score
from threewe.errors import ConfigError, TimeoutError
from threewe.gym.batch import TASK_FIELDS
from threewe.gym.env import Env
from threewe.robot import Robot

FOREVER = 2**31 - 1  # steps
POSE_EVERY = 10  # ticks between two poses of a trajectory
ADVICE = 200  # characters of what an agent failed of
SLOWEST = 1.0  # [Hz] of agents that act


@dataclass(frozen=True)
class Settings:
    """What a run is made with, the same in all of its episodes."""

    hardware: str = "3we_standard_v2"
    backend: str = "mock"
    noise: str = "realistic"
    randomization: str = "none"
    control_rate: float = 10.0  # [Hz] of agents that act
    seed: int = 0  # of the agents' own choices

    @property
    def official(self) -> bool:
        """Whether results with it may stand on a board."""
        return (self.hardware, self.noise, self.randomization) == ("3we_standard_v2", "realistic", "none")


@dataclass
class Attempt:
    """What an episode came to, besides its metrics."""

    end: str  # `stop`, `time`, `failure`
    failure: str = ""  # of the agent
    drive: TrueDrive | None = None
    actions: NDArray[np.float32] | None = None  # (steps, 3) of an agent that acts
    grid: OccupancyGrid | None = None  # the robot's own map, of an exploration
    talk: bytes = b""  # with a model


def attempt(
    task_name: str, episode: Episode, agent_name: str, settings: Settings, talk: str | None = None
) -> dict[str, Any]:
    """Drives one episode, and returns what JSON holds. `talk` is a conversation in base 64, repeated as it was."""
    if talk is not None:
        with NamedTemporaryFile() as file:
            file.write(base64.b64decode(talk))
            file.flush()
            return attempt_with(task_name, episode, InstructedByModel("", Path(file.name)), settings)
    return attempt_with(task_name, episode, make_agent(task_name, agent_name), settings)


def attempt_with(task_name: str, episode: Episode, agent: Any, settings: Settings) -> dict[str, Any]:
    """The same with an agent that was made already."""
    task, place = TASKS[task_name], place_of(episode.scene, settings.hardware)
    if hasattr(agent, "yardstick"):
        return reference(task, episode)
    drive = _run if hasattr(agent, "run") else _act
    tried = drive(task, episode, place, agent, settings)
    return record(tried, score(task, episode, place, tried.drive, tried.end, tried.grid))


def lost(task_name: str, episode: Episode, settings: Settings, why: str) -> dict[str, Any]:
    """What an episode came to whose process was lost."""
    task, place = TASKS[task_name], place_of(episode.scene, settings.hardware)
    return record(Attempt("failure", why), score(task, episode, place, None, "failure"))


def reference(task: Task, episode: Episode) -> dict[str, Any]:
    """What the yardstick of an episode comes to by the task's metrics."""
    best = episode.yardstick or Yardstick(0.0, 0.0, 0.0)
    metrics: Metrics = {"path_length": best.length, "duration": best.duration, "contacts": 0.0, "collision_speed": 0.0}
    if task.name == "exploration":
        metrics |= {"coverage": best.success, "cell_ratio": best.success, "map_accuracy": 1.0}
    else:
        part = best.success * episode.geodesic / max(episode.geodesic, best.length)
        metrics |= {"success": best.success, "success_without_contact": best.success, "spl": part, "soft_spl": part}
        metrics["distance_to_success"] = 0.0 if best.success else episode.geodesic
    return record(Attempt("stop"), metrics)


def record(tried: Attempt, metrics: Metrics) -> dict[str, Any]:
    """As JSON holds it: what can be replayed is in base 64."""
    poses = tried.drive.poses if tried.drive else np.zeros((0, 3))
    commands = tried.drive.commands if tried.drive else np.zeros((0, 3))
    shown: dict[str, Any] = {
        "end": tried.end,
        "failure": tried.failure,
        "ticks": len(commands),
        "metrics": dict(sorted(metrics.items())),
        "trajectory": trajectory_of(poses),
    }
    replayed = {"commands": as_base64(commands.astype("<f8"))}
    if tried.actions is not None:
        replayed["actions"] = as_base64(tried.actions.astype("<f4"))
    if tried.talk:
        replayed["talk"] = base64.b64encode(tried.talk).decode()
    if tried.grid is not None:
        grid = tried.grid
        shown["grid"] = {"origin": list(grid.origin), "resolution": grid.resolution, "shape": [*grid.data.shape]}
        replayed["grid"] = as_base64(np.ascontiguousarray(grid.data))
    return {**shown, "replayed": replayed}


def replay(task_name: str, episode: Episode, settings: Settings, end: str, commands: NDArray[np.float64],
           grid: OccupancyGrid | None = None) -> dict[str, Any]:  # fmt: skip
    """What the commands of an episode come to: below the gate, in a world made anew."""
    task, place = TASKS[task_name], place_of(episode.scene, settings.hardware)
    if not len(commands):
        return record(Attempt("failure"), score(task, episode, place, None, "failure"))
    drive = Replay(robot_options(episode, settings), np.ascontiguousarray(commands, np.float64))
    tried = Attempt(end, drive=drive, grid=grid)
    return record(tried, score(task, episode, place, drive, end, grid))


def robot_options(episode: Episode, settings: Settings) -> RobotOptions:
    """The robot of an episode."""
    return RobotOptions(
        backend=known_backend(settings.backend),
        hardware=settings.hardware,
        scene=scene_asset(episode.scene),
        noise=settings.noise,
        seed=episode.seed,
        start_pose=Pose2D(*episode.start),
        randomization=settings.randomization,
    )


def assignment_of(task: Task, episode: Episode, settings: Settings, map_from_start: Pose2D) -> Assignment:
    """What the agent of an episode is given."""
    goal = None
    if episode.goal is not None:
        there = map_from_start * (Pose2D(*episode.start).inverse() * Pose2D(*episode.goal, 0.0))
        goal = (there.x, there.y)
    key = f"{settings.seed}/{task.name}/{episode.scene}/{episode.index}".encode()
    seed = int.from_bytes(hashlib.sha256(key).digest()[:4], "little")
    places: tuple[Any, ...] = ()
    if task.name == "vln":
        goal = None  # which the words say
        map_from_scene = map_from_start * Pose2D(*episode.start).inverse()
        places = tuple(rooms_of(episode.scene, map_from_scene))
    limit = task.time_limit(episode)
    return Assignment(task.name, goal, episode.category, episode.instruction, places, limit, seed)


def rooms_of(scene: str, map_from_scene: Pose2D) -> Iterator[tuple[str, tuple[tuple[float, float], ...]]]:
    """Names and borders of the rooms of a scene, in `map`."""
    for place in places_of_scene(load_scene(scene)):
        corners = [map_from_scene * Pose2D(x, y, 0.0) for x, y in place.polygon]
        yield place.name, tuple((corner.x, corner.y) for corner in corners)


def _run(task: Task, episode: Episode, place: Place, agent: Any, settings: Settings) -> Attempt:
    """A program around a `Robot`."""
    privileged = bool(getattr(agent, "privileged", False))
    own = agent.robot_options(episode, place) if privileged and hasattr(agent, "robot_options") else {}
    robot = Robot(
        settings.backend,
        settings.hardware,
        scene_asset(episode.scene),
        noise=settings.noise,
        seed=episode.seed,
        start_pose=episode.start,
        randomization=settings.randomization,
        image_size=getattr(agent, "options", {}).get("image_size"),
        **own,
    )
    log = DriveLog(robot._world)
    assignment = assignment_of(task, episode, settings, Pose2D(*own.get("initial_pose", (0.0, 0.0, 0.0))))
    if not privileged:
        robot._simulation = None  # as on a real robot
    return asyncio.run(_drive(robot, log, agent, assignment))


async def _drive(robot: Robot, log: DriveLog, agent: Any, assignment: Assignment) -> Attempt:
    async with robot:
        tried = Attempt("stop", drive=log)
        try:
            if hasattr(agent, "reset"):
                agent.reset(assignment)
            async with robot.timeout(assignment.time_limit - robot.now):
                await agent.run(robot, assignment)
        except MemoryError:
            raise
        except Exception as error:
            tried.end, tried.failure = "failure", said(error)
            if isinstance(error, TimeoutError) and len(log) * TICK >= assignment.time_limit:  # not one of its own
                tried.end, tried.failure = "time", ""
        tried.talk = agent.talk if isinstance(agent, InstructedByModel) else b""
        log.end()
        if tried.end == "stop" and len(log) * TICK >= assignment.time_limit:
            tried.end = "time"
        if assignment.task == "exploration":
            tried.grid = robot.get_map()
        return tried


def _act(task: Task, episode: Episode, place: Place, agent: Any, settings: Settings) -> Attempt:
    """A policy in an environment around a `Robot`."""
    del place
    given = requested_options(agent, task, settings)
    env, log = _environment(task.environment, episode.scene, settings, tuple(sorted(given.items())))
    assignment = assignment_of(task, episode, settings, Pose2D())
    tried = Attempt("time", drive=log)
    actions: list[NDArray[np.float32]] = []
    where: dict[str, Any] = {"start": episode.start, "goal": episode.goal, "object_goal": episode.category}
    observation, _ = env.reset(
        seed=episode.seed, options={name: value for name, value in where.items() if value is not None}
    )
    try:
        if hasattr(agent, "reset"):
            agent.reset(assignment)
        over = False
        while not over and len(log) * TICK < assignment.time_limit:
            action = agent.act(observation)
            observation, _, over, _, _ = env.step(action)
            actions.append(np.asarray(action, np.float32))
        if len(log) * TICK < assignment.time_limit:
            tried.end = "stop"
    except MemoryError:
        raise
    except Exception as error:
        tried.end, tried.failure = "failure", said(error)
    tried.actions = np.array(actions, np.float32).reshape(-1, 3)
    if task.name == "exploration":
        assert isinstance(env._core, RobotEnv)
        tried.grid = env._core.map
    return tried


def requested_options(agent: Any, task: Task, settings: Settings) -> dict[str, Any]:
    """What the environment of an agent that acts is made with, of `EnvOptions`."""
    given = dict(getattr(agent, "options", {}))
    if given.setdefault("control_rate", settings.control_rate) < SLOWEST:
        raise ConfigError(f"control_rate: expected {SLOWEST:g} Hz or more, got {given['control_rate']:g}")
    given.setdefault("observations", ("lidar", "pose", "velocity", *TASK_FIELDS[task.environment]))
    if task.name == "pointnav":
        given |= {"stop": True, "contact": "count"}
    return given


@lru_cache(maxsize=SCENES_KEPT)
def _environment(
    task: str, scene: str, settings: Settings, options: tuple[tuple[str, Any], ...]
) -> tuple[Env, DriveLog]:
    """One that many episodes are driven in; its log begins anew with each."""
    env = Env(
        task=task,
        scene=scene_asset(scene),
        backend=settings.backend,
        hardware=settings.hardware,
        noise=settings.noise,
        randomization=settings.randomization,
        max_steps=FOREVER,
        **dict(options),
    )
    assert isinstance(env._core, RobotEnv)
    return env, DriveLog(env._core)


def trajectory_of(poses: NDArray[np.float64]) -> list[list[float]]:
    """[x, y, theta] every 0.2 s, and at the end, in millimetres and milliradians."""
    rows = poses[::POSE_EVERY].tolist() + (poses[-1:].tolist() if len(poses) % POSE_EVERY != 1 else [])
    return [[round(value, 3) for value in row] for row in rows]


def said(error: Exception) -> str:
    """What an agent failed of, in a line."""
    words = " ".join(f"{type(error).__name__}: {error}".split())
    return "".join(letter if letter.isprintable() else "?" for letter in words)[:ADVICE]


def as_base64(values: NDArray[Any]) -> str:
    """The bytes of an array."""
    return base64.b64encode(values.tobytes()).decode()


def from_base64(text: str, kind: str) -> NDArray[Any]:
    """An array of rows of three."""
    return np.frombuffer(base64.b64decode(text), kind).reshape(-1, 3)
