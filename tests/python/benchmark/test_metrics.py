"""Metrics of drives that were made by hand: values, borders, and which interval each figure has."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from threewe import OccupancyGrid, Pose2D, SceneTables
from threewe._core import CoverageMeter, Replay
from threewe.benchmark import Episode, load_episodes, summarize
from threewe.benchmark.attempt import Settings, robot_options
from threewe.benchmark.statistics import bootstrap, wilson
from threewe.benchmark.tasks import TASKS, TICK, cell_ratio, map_accuracy, place_of, score

PLACE = place_of("apartment_v1", "3we_standard_v2")
TICKS = 100
FREE, UNKNOWN, WALL = 0, -1, 100


@dataclass(frozen=True)
class Drive:
    """What `score` reads of a drive."""

    poses: NDArray[np.float64]
    length: float = 5.0
    collision_speed: float = 0.0
    touched: int = 0

    @property
    def commands(self) -> NDArray[np.float64]:
        """One a tick."""
        return np.zeros_like(self.poses)

    def contacts(self, _: SceneTables) -> int:
        """How often it touched."""
        return self.touched


def first(name: str) -> Episode:
    return next(one for one in load_episodes(name)["episodes"] if one.scene == PLACE.scene.name)


def standing(x: float, y: float, ticks: int = TICKS, **how: Any) -> Drive:
    return Drive(np.tile([x, y, 0.0], (ticks, 1)), **how)


def arrived(task: str, left: float, end: str = "stop", towards: float = 0.0, **how: Any) -> dict[str, Any]:
    """The metrics of a drive that ends so far [m] from its goal, around which there is room."""
    episode = replace(first("pointnav_val_v1"), geodesic=4.0)
    assert episode.goal is not None
    assert PLACE.tables.clearance(Pose2D(*episode.goal, 0.0)) > 0.4
    x, y = episode.goal[0] + left * math.cos(towards), episode.goal[1] + left * math.sin(towards)
    return dict(score(TASKS[task], episode, PLACE, standing(x, y, **how), end))  # type: ignore[arg-type]


@pytest.mark.parametrize(("task", "border"), [("pointnav", 0.5), ("vln", 1.0)])
@pytest.mark.parametrize("towards", [0.0, 3.1])
def test_stop_is_right_up_to_the_border(task: str, border: float, towards: float) -> None:
    within, beyond = (arrived(task, border + by, towards=towards) for by in (-0.001, 0.001))
    assert (within["success"], within["spl"]) == (1.0, pytest.approx(4.0 / 5.0))
    assert within["distance_to_success"] == 0.0
    assert (beyond["success"], beyond["success_without_contact"], beyond["spl"]) == (0.0, 0.0, 0.0)
    assert beyond["distance_to_success"] == pytest.approx(0.001, abs=1e-9)


def test_who_does_not_say_stop_has_not_arrived() -> None:
    for end in ("time", "failure"):
        there = arrived("pointnav", 0.1, end)
        assert (there["success"], there["spl"], there["distance_to_success"]) == (0.0, 0.0, 0.0)
        assert there["soft_spl"] == pytest.approx(4.0 / 5.0)
    assert arrived("pointnav", 1.0)["soft_spl"] == pytest.approx((1.0 - 1.0 / 4.0) * 4.0 / 5.0)
    assert arrived("pointnav", 0.1)["duration"] == pytest.approx(TICKS * TICK)


def test_a_success_is_without_contact_up_to_a_slow_touch() -> None:
    rates = ("success", "success_without_contact")
    for speed, without in [(0.0, 1.0), (0.05, 1.0), (0.051, 0.0), (0.4, 0.0)]:
        touched = arrived("pointnav", 0.1, collision_speed=speed, touched=3)
        assert [touched[rate] for rate in rates] == [1.0, without], speed
        assert (touched["contacts"], touched["collision_speed"]) == (3.0, speed)
    assert [arrived("pointnav", 2.0)[rate] for rate in rates] == [0.0, 0.0]


def test_an_agent_that_never_drove_has_all_its_way_to_go() -> None:
    for task in TASKS:
        episode = replace(first("pointnav_val_v1"), geodesic=4.0)
        nothing = score(TASKS[task], episode, PLACE, None, "failure")
        assert all(nothing[name] == 0.0 for name in (*TASKS[task].rates, "path_length"))
        left = nothing.get("distance_to_success")
        assert left == (None if task == "exploration" else 4.0)
        assert nothing.get("coverage_over_time") == ([0.0] * 10 if task == "exploration" else None)


def search(episode: Episode, pose: Pose2D, end: str) -> dict[str, Any]:
    """The metrics of a robot that stands there all the time."""
    options = robot_options(replace(episode, start=(pose.x, pose.y, pose.theta)), Settings(noise="ideal"))
    return dict(score(TASKS["objectnav"], episode, PLACE, Replay(options, np.zeros((TICKS, 3))), end))


def test_a_search_has_the_way_to_the_nearest_place_of_success_to_go() -> None:
    episode = first("objectnav_val_v1")
    at_start = search(episode, Pose2D(*episode.start), "stop")
    assert (at_start["success"], at_start["spl"]) == (0.0, 0.0)
    assert at_start["distance_to_success"] == pytest.approx(episode.geodesic)
    assert episode.geodesic > 2.0
    nearer = next(
        pose
        for pose in poses_before(episode, 2.5)
        if 0.5 < PLACE.object_nav.distance(str(episode.category), (pose.x, pose.y)) < episode.geodesic
    )
    left = search(episode, nearer, "stop")["distance_to_success"]
    assert left == PLACE.object_nav.distance(str(episode.category), (nearer.x, nearer.y))
    # the thing is at least as far as the nearest place from which it counts as found
    assert left <= min(math.dist((nearer.x, nearer.y), (thing.pose.x, thing.pose.y)) for thing in things(episode))


def test_a_search_that_found_it_has_nothing_to_go() -> None:
    episode = first("objectnav_val_v1")
    near = ((pose, search(episode, pose, "stop")) for pose in poses_before(episode, 0.8))
    found = list(islice(((pose, metrics) for pose, metrics in near if metrics["success"]), 10))
    assert found
    for pose, metrics in found:
        assert (metrics["distance_to_success"], metrics["success_without_contact"]) == (0.0, 1.0)
        silent = search(episode, pose, "time")
        assert silent["success"] == 0.0
        assert silent["distance_to_success"] < 0.3, "the tables know the border to a few cells"
    turned = [search(episode, pose * Pose2D(0.0, 0.0, math.pi), "stop") for pose, _ in found]
    assert 0.0 in {metrics["success"] for metrics in turned}, "one that looks the other way sees nothing of the kind"


def things(episode: Episode) -> list[Any]:
    return [thing for thing in PLACE.scene.objects if thing.category == episode.category]


def poses_before(episode: Episode, distance: float) -> list[Pose2D]:
    """Free poses so far [m] from something of the episode's category, which look at it."""
    poses = []
    for thing in things(episode):
        for angle in np.arange(0.0, 2.0 * math.pi, 0.2):
            x, y = thing.pose.x + distance * math.cos(angle), thing.pose.y + distance * math.sin(angle)
            pose = Pose2D(x, y, float(angle) + math.pi)
            left = PLACE.object_nav.distance(str(episode.category), (x, y))
            if PLACE.tables.clearance(pose) > 0.02 and math.isfinite(left):
                poses.append(pose)
    return poses


def grid(rows: list[list[int]], resolution: float = 0.05, origin: tuple[float, float] = (0.0, 0.0)) -> OccupancyGrid:
    return OccupancyGrid(np.array(rows, np.int8), resolution, origin)


def test_the_cell_ratio_compares_areas_wherever_they_lie() -> None:
    truth = grid([[FREE] * 8, [25] * 8, [26] * 8, [UNKNOWN] * 8, [WALL] * 8])  # 16 free cells of 5 cm
    assert cell_ratio(truth, truth) == 1.0
    assert cell_ratio(grid([[FREE, FREE, 25, 24], [26, UNKNOWN, WALL, 65]]), truth) == 4 / 16
    assert cell_ratio(grid([[FREE, FREE]], 0.1, (-7.0, 30.0)), truth) == pytest.approx(8 / 16)
    assert cell_ratio(grid([[FREE] * 17]), truth) == 1.0, "no more than there is"
    assert cell_ratio(grid([[UNKNOWN] * 4]), truth) == 0.0


def test_a_map_is_as_accurate_as_its_cells_are_right_within_one() -> None:
    truth = grid([[FREE] * 6 + [WALL] * 2 + [UNKNOWN] * 2] * 6)  # free left of x = 0.3 m, a wall up to 0.4 m
    own = np.full((6, 10), UNKNOWN)
    assert map_accuracy(grid(own.tolist()), truth, Pose2D()) == 0.0
    own[2, [1, 5, 6]] = FREE  # the third is in the wall, next to what is free
    assert map_accuracy(grid(own.tolist()), truth, Pose2D()) == 1.0
    own[2, 7] = FREE  # two cells deep in it
    assert map_accuracy(grid(own.tolist()), truth, Pose2D()) == 3 / 4
    own[3, [2, 5]] = WALL  # the first in the open, the second in front of the wall
    assert map_accuracy(grid(own.tolist()), truth, Pose2D()) == 4 / 6
    own[4, 8] = WALL  # of which the truth says nothing
    assert map_accuracy(grid(own.tolist()), truth, Pose2D()) == 4 / 6
    assert map_accuracy(grid(own.tolist(), origin=(5.0, 1.0)), truth, Pose2D(-5.0, -1.0, 0.0)) == 4 / 6


def test_coverage_is_noted_at_each_tenth_of_the_time() -> None:
    episode = replace(first("exploration_val_v1"), yardstick=None)
    assert TASKS["exploration"].time_limit(episode) == 60.0
    here = Pose2D(*episode.start)
    free = [PLACE.tables.sample_free_pose(seed) for seed in range(5)]
    there = max(free, key=lambda pose: math.dist((pose.x, pose.y), (here.x, here.y)))
    meter = CoverageMeter(PLACE.scene, PLACE.profile)
    meter.observe(here)
    one = meter.crossed()
    meter.observe(there)
    both = meter.crossed()
    assert 0.0 < one < both < 1.0

    def over_time(*stays: tuple[Pose2D, int]) -> dict[str, Any]:
        poses = np.array([[*pose] for pose, ticks in stays for _ in range(ticks)])
        drive: Any = Drive(poses)
        return dict(score(TASKS["exploration"], episode, PLACE, drive, "stop"))

    moved = over_time((here, 1500), (there, 1500))
    assert moved["coverage_over_time"] == [one] * 5 + [both] * 5
    assert moved["crossed"] == both
    assert moved["coverage"] == moved["cell_ratio"] == 0.0, "without a map of its own"
    assert over_time((here, 1490), (there, 10))["coverage_over_time"] == [one] * 4 + [both] * 6
    assert over_time((here, 20))["coverage_over_time"] == [one] * 10, "what it has seen stays seen"


@pytest.mark.parametrize("task", TASKS)
def test_rates_have_wilsons_interval_and_means_the_bootstraps(task: str) -> None:
    names = (*TASKS[task].rates, *TASKS[task].means)
    values = [1.0, 0.0, 1.0, 1.0, 0.0]
    rows = [
        {"episode": {"scene": scene}, "failure": failure, "metrics": dict.fromkeys(names, value)}
        for value, scene, failure in zip(values, "aabbb", ["", "raised", "", "", ""], strict=True)
    ]
    summary = summarize(task, rows)
    assert list(summary) == ["all", "a", "b"]
    for group, some in {"all": values, "a": values[:2], "b": values[2:]}.items():
        hits, count = int(sum(some)), len(some)
        assert sorted(summary[group]) == sorted([*names, "agent_failures"])
        for name in names:
            low, high = wilson(hits, count) if name in TASKS[task].rates else bootstrap(some)
            assert summary[group][name] == {"value": hits / count, "low": low, "high": high, "count": count}, name
    assert wilson(3, 5) == pytest.approx((0.2307, 0.8824), abs=1e-4)
    assert bootstrap(values) != wilson(3, 5)
    assert [summary[group]["agent_failures"]["value"] for group in summary] == [1, 1, 0]
    rates = {"success", "success_without_contact"}
    assert set(TASKS[task].rates) == (set() if task == "exploration" else rates)
    assert not rates & set(TASKS[task].means)
