"""Tasks of benchmarks and their metrics: what a drive came to, by the truth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import (
    CoverageMeter,
    ObjectNav,
    OccupancyGrid,
    Pose2D,
    RobotProfile,
    Scene,
    SceneTables,
    TrueDrive,
    load_map,
    spl,
)
from threewe.benchmark.buildings import load_scene
from threewe.benchmark.episodes import Episode
from threewe.exporting import export

TICK = 0.02  # [s]
SUCCESS_DISTANCE = {"pointnav": 0.5, "vln": 1.0}  # [m] to the goal, by the shortest path
CONTACT_SPEED = 0.05  # [m/s]: slower touches do no harm
LOOK_EVERY = 10  # ticks between two looks of the coverage meter
SCENES_KEPT = 8  # of those that episodes lie in, at a time
SHARES = 10  # of an exploration's time at which its coverage is noted
FREE, OCCUPIED = 25, 65  # of OccupancyGrid: at most, at least

NAMES = {"pointnav": "PointNav", "objectnav": "ObjectNav", "vln": "VLN", "exploration": "Exploration"}
TITLES = {
    "success": "SR",
    "success_without_contact": "SR without contact",
    "spl": "SPL",
    "soft_spl": "SoftSPL",
    "coverage": "coverage",
    "cell_ratio": "cell ratio",
    "map_accuracy": "map accuracy",
    "contacts": "contacts",
    "duration": "time [s]",
    "distance_to_success": "left to go [m]",
    "agent_failures": "agent failed",
}

Metrics = dict[str, float | list[float]]


@dataclass(frozen=True)
class Task:
    """What robots are asked to do."""

    name: str
    environment: str  # of `threewe.gym.Env`, for agents that act
    rates: tuple[str, ...]  # metrics that are 0 or 1 in each episode
    means: tuple[str, ...]  # the others that results show
    headline: str  # the metric by which agents are ranked

    def time_limit(self, episode: Episode) -> float:
        """[s] of robot time, from 0: an agent that stops later has not."""
        if self.name == "exploration":
            return max(60.0, 1.5 * (episode.yardstick.duration if episode.yardstick else 0.0))
        return {"pointnav": 180.0, "objectnav": 300.0, "vln": 300.0}[self.name]


TASKS = {
    "pointnav": Task(
        "pointnav",
        "navigation",
        ("success", "success_without_contact"),
        ("spl", "soft_spl", "contacts", "duration", "distance_to_success"),
        "spl",
    ),
    "objectnav": Task(
        "objectnav",
        "object_nav",
        ("success", "success_without_contact"),
        ("spl", "contacts", "duration", "distance_to_success"),
        "spl",
    ),
    "vln": Task(
        "vln",
        "vln",
        ("success", "success_without_contact"),
        ("spl", "contacts", "duration", "distance_to_success"),
        "spl",
    ),
    "exploration": Task(
        "exploration",
        "exploration",
        (),
        ("coverage", "cell_ratio", "map_accuracy", "contacts", "duration"),
        "coverage",
    ),
}


@dataclass(frozen=True)
class Place:
    """A scene as one robot meets it, and what is worked out once. Privileged."""

    scene: Scene
    profile: RobotProfile
    tables: SceneTables

    @property
    def object_nav(self) -> ObjectNav:
        """Where STOP is right."""
        return _object_nav(self)

    @property
    def true_map(self) -> OccupancyGrid:
        """What a perfect lidar would map."""
        return _true_map(self)

    def __hash__(self) -> int:
        return hash((self.scene.name, self.profile.name))


@lru_cache(maxsize=SCENES_KEPT)
def place_of(scene: str, hardware: str) -> Place:
    """A scene of an episode."""
    loaded, profile = load_scene(scene), RobotProfile.load(hardware)
    return Place(loaded, profile, SceneTables(loaded, profile))


@lru_cache(maxsize=SCENES_KEPT)
def _object_nav(place: Place) -> ObjectNav:
    return ObjectNav(place.tables, place.profile)


@lru_cache(maxsize=SCENES_KEPT)
def _true_map(place: Place) -> OccupancyGrid:
    with TemporaryDirectory() as folder:
        [file] = [path for path in export(place.scene, place.profile, "map", folder) if path.suffix == ".yaml"]
        return load_map(str(file))


def score(task: Task, episode: Episode, place: Place, drive: TrueDrive | None, end: str, grid: Any = None) -> Metrics:
    """The metrics of an episode.

    Args:
        task: what was to be done.
        episode: where.
        place: its scene.
        drive: what was driven; None where the agent's process was lost.
        end: `stop`, where the agent says that it is done; `time` or `failure`.
        grid: the robot's own map at the end, of an exploration.
    """
    if drive is None or not len(drive.commands):
        return _nothing(task, episode)
    common: Metrics = {
        "contacts": float(drive.contacts(place.tables)),
        "collision_speed": drive.collision_speed,
        "path_length": drive.length,
        "duration": len(drive.commands) * TICK,
    }
    if task.name == "exploration":
        return _explored(task, episode, place, drive, grid) | common
    return _arrived(task, episode, place, drive, end) | common


def _nothing(task: Task, episode: Episode) -> Metrics:
    """Of an agent that never drove."""
    zero = dict.fromkeys((*task.rates, *task.means, "collision_speed", "path_length"), 0.0)
    metrics: Metrics = {**zero}
    if task.name == "exploration":
        metrics["coverage_over_time"] = [0.0] * SHARES
    else:
        metrics["distance_to_success"] = episode.geodesic
    return metrics


def _arrived(task: Task, episode: Episode, place: Place, drive: TrueDrive, end: str) -> Metrics:
    if task.name in SUCCESS_DISTANCE:
        near = SUCCESS_DISTANCE[task.name]
        left = _geodesic_left(episode, place, drive.poses)
        success = end == "stop" and left <= near
        left = max(0.0, left - near)
    else:
        assert episode.category is not None
        search = place.object_nav
        success = end == "stop" and bool(search.found(place.profile, episode.category, drive))
        left = 0.0 if success else _search_left(search, episode, drive.poses)
    metrics: Metrics = {
        "success": float(success),
        "success_without_contact": float(success and drive.collision_speed <= CONTACT_SPEED),
        "spl": spl(success, episode.geodesic, drive.length),
        "distance_to_success": left,
    }
    if task.name == "pointnav":
        metrics["soft_spl"] = soft_spl(left + near if left else 0.0, episode.geodesic, drive.length)
    return metrics


def soft_spl(left: float, shortest: float, driven: float) -> float:
    """SPL with the share of the way that was made good in place of success (Datta et al. 2020). Lengths in [m]."""
    return max(0.0, 1.0 - left / shortest) * shortest / max(shortest, driven)


def _geodesic_left(episode: Episode, place: Place, poses: NDArray[np.float64]) -> float:
    """[m] of the shortest path; squeezed against something the robot is as far as it was."""
    assert episode.goal is not None
    [last] = place.tables.geodesics([tuple(poses[-1, :2])], episode.goal)
    if math.isfinite(last):
        return last
    lengths = np.asarray(place.tables.geodesics([tuple(pose) for pose in poses[:, :2]], episode.goal))
    finite = lengths[np.isfinite(lengths)]
    return float(finite[-1]) if len(finite) else episode.geodesic


def _search_left(search: ObjectNav, episode: Episode, poses: NDArray[np.float64]) -> float:
    assert episode.category is not None
    for x, y, _ in poses[::-1]:
        left = search.distance(episode.category, (x, y))
        if math.isfinite(left):
            return left
    return episode.geodesic


def _explored(task: Task, episode: Episode, place: Place, drive: TrueDrive, grid: OccupancyGrid | None) -> Metrics:
    meter = CoverageMeter(place.scene, place.profile)
    ticks = round(task.time_limit(episode) / TICK)
    marks = [ticks * (i + 1) // SHARES for i in range(SHARES)]
    over_time: list[float] = []
    for tick, (x, y, theta) in enumerate(drive.poses.tolist()):
        if tick % LOOK_EVERY == 0:
            meter.observe(Pose2D(x, y, theta))
        while len(over_time) < SHARES and tick >= marks[len(over_time)] - 1:
            over_time.append(meter.crossed())
    over_time += [meter.crossed()] * (SHARES - len(over_time))
    start = Pose2D(*episode.start)
    return {
        "coverage": meter.coverage(grid, start) if grid is not None else 0.0,
        "crossed": meter.crossed(),
        "coverage_over_time": over_time,
        "cell_ratio": cell_ratio(grid, place.true_map) if grid is not None else 0.0,
        "map_accuracy": map_accuracy(grid, place.true_map, start) if grid is not None else 0.0,
    }


def cell_ratio(grid: OccupancyGrid, truth: OccupancyGrid) -> float:
    """The area that a map marks free over the area that is, at most 1: wherever it lies."""
    own = float(np.count_nonzero((grid.data >= 0) & (grid.data <= FREE))) * grid.resolution**2
    return min(1.0, own / float(np.count_nonzero((truth.data >= 0) & (truth.data <= FREE)) * truth.resolution**2))


def map_accuracy(grid: OccupancyGrid, truth: OccupancyGrid, scene_from_map: Pose2D) -> float:
    """The share of the cells that a map marks free or occupied that are so in truth, within one cell.

    Cells of which the truth is not known, as outside of the scene, count for nothing.
    """
    rows, columns = np.nonzero((grid.data >= 0) & ((grid.data <= FREE) | (grid.data >= OCCUPIED)))
    x = grid.origin[0] + (columns + 0.5) * grid.resolution
    y = grid.origin[1] + (rows + 0.5) * grid.resolution
    ahead = Pose2D(0.0, 0.0, scene_from_map.theta) * Pose2D(1.0, 0.0, 0.0)  # the same bits everywhere
    c, s = ahead.x, ahead.y
    scene_x, scene_y = scene_from_map.x + c * x - s * y, scene_from_map.y + s * x + c * y
    i = np.floor((scene_y - truth.origin[1]) / truth.resolution).astype(int)
    j = np.floor((scene_x - truth.origin[0]) / truth.resolution).astype(int)
    inside = (i >= 1) & (i < truth.height - 1) & (j >= 1) & (j < truth.width - 1)
    i, j = i[inside], j[inside]
    occupied = grid.data[rows[inside], columns[inside]] >= OCCUPIED
    around = np.stack([truth.data[i + di, j + dj] for di in (-1, 0, 1) for dj in (-1, 0, 1)])
    known = truth.data[i, j] >= 0
    right = np.where(occupied, (around >= OCCUPIED).any(axis=0), ((around >= 0) & (around <= FREE)).any(axis=0))
    return float(right[known].mean()) if known.any() else 0.0


@dataclass(frozen=True)
class Assignment:
    """What an agent is asked to do. It says nothing of where in the scene the robot is."""

    task: str
    goal: tuple[float, float] | None  # x, y [m] in the robot's `map` frame, of PointNav
    category: str | None  # of what is looked for, of ObjectNav
    instruction: str | None  # English, of VLN
    places: tuple[tuple[str, tuple[tuple[float, float], ...]], ...]  # rooms by name, with borders [m] in `map`, of VLN
    time_limit: float  # [s] of robot time
    seed: int  # of the agent's own choices
