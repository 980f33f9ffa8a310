"""What calls return are values: equal or not, hashed, copied, pickled and, where they are numbers, arrays."""

from __future__ import annotations

import asyncio
import copy
import json
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import threewe
from threewe import ContractError, Pose2D, Reason, Robot, Velocity, Zone
from threewe.slam import SlamConfig

NO_VALUES = {"Calibration", "Robot", "Simulation", "World", "CoverageMeter", "SceneTables", "Snapshot"}


@pytest.fixture(scope="module")
def values() -> list[Any]:
    """One of each type and more, as a robot makes them."""
    return asyncio.run(collect())


async def collect() -> list[Any]:
    made: list[Any] = [Pose2D(1, 2, 3), Zone([(0, 0), (1, 0), (0, 1)], speed_limit=0.2), SlamConfig(range_max=8.0)]
    scene = threewe.Scene.load("apartment_v1")
    async with Robot(hardware="3we_depth_v2", scene=scene.name) as robot:
        ticks: list[threewe.TickView] = []
        number = robot.observe(ticks.append)
        plans: list[Any] = []
        progress: list[Any] = []

        def look(now: threewe.Progress) -> None:
            progress.append(now)
            plans.append(robot.get_plan())

        made += [await robot.move_to(1.0, 0.0, on_progress=look), await robot.explore(timeout=0.1)]
        robot.unobserve(number)
        robot.name_place("dock")
        done = await robot.execute_instruction("look around, then wait 1 second")
        made += [done, *done.steps, *robot.get_places(), *robot.get_things()]
        truth = robot.simulation
        assert truth is not None
        made += [
            robot.get_pose(),
            robot.get_velocity(),
            robot.get_lidar_scan(),
            robot.get_rgbd_image(),
            robot.get_imu(),
        ]
        made += [robot.get_odometry(), robot.get_battery_state(), robot.get_map(), robot.profile, robot.features]
        made += [*robot.health.values(), *robot.get_ultrasonic_ranges().values(), *robot.features.sensors, truth.look()]
        made += [ticks[-1], *ticks[-1].samples, ticks[-1].pose, progress[0], next(plan for plan in plans if plan)]
        profile = robot.profile
        made += [profile.lidar, profile.imu, profile.camera, profile.ultrasonics, profile.battery]
        made += [profile.parameters()[0], profile.operating_limits, robot.get_rgbd_image().intrinsics]
        made += [scene.walls[0], scene.doors[0], scene.rooms[0], scene.objects[0], scene.objects[0].prisms[0], scene]
        made += [threewe.SceneTables(scene, profile).sample_episode(3)]
    people = threewe.Scene.load("dynamic_v1")
    async with Robot(scene=people.name, noise="ideal") as robot:
        await robot.sleep(3.0)
        assert robot.simulation is not None
        made += [people.people[0], *robot.simulation.people(), *robot.get_people()]
    return made


def test_every_type_of_the_public_api_is_there(values: list[Any]) -> None:
    types = {getattr(threewe, name) for name in threewe.__all__}
    of_core = {t.__name__ for t in types if isinstance(t, type) and t.__module__ == "threewe._core"}
    without_enums = {name for name in of_core if not issubclass(getattr(threewe, name), str)}
    assert without_enums - NO_VALUES - {type(value).__name__ for value in values} == set()


@pytest.mark.parametrize("way", [copy.copy, copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))])
def test_copies_are_equal(values: list[Any], way: Callable[[Any], Any]) -> None:
    for value in values:
        again = way(value)
        assert type(again) is type(value)
        if not isinstance(value, threewe.Scene):
            assert (again == value, again != value, hash(again) == hash(value)) == (True, False, True), value


def test_different_values_differ(values: list[Any]) -> None:
    for value in values:
        if isinstance(value, threewe.Scene):
            continue
        assert value != object()
        assert sum(value == other for other in values if other is not value) <= 3  # a pose at rest may come again
    assert Pose2D(1, 2, 0.5) != Pose2D(1, 2, 0.5 + 1e-15)
    assert Pose2D(0.0) == Pose2D(-0.0)
    assert hash(Pose2D(0.0)) == hash(Pose2D(-0.0))
    assert Pose2D(float("nan")) != Pose2D(float("nan"))


def test_what_is_damaged_is_refused() -> None:
    state = Pose2D(1, 2, 3).__getstate__()
    for wrong in (state[:-1], state + b"x", b""):
        with pytest.raises(ContractError, match="another version of 3we, or is damaged"):
            Pose2D.__new__(Pose2D).__setstate__(wrong)


def test_reasons_are_their_names(values: list[Any]) -> None:
    result = next(value for value in values if isinstance(value, threewe.MoveResult))
    assert result.reason == "reached"
    assert result.reason is Reason.reached
    assert {"reached": 1}[result.reason] == 1
    assert (str(result.reason), f"{result.reason}", json.dumps(result.reason)) == ("reached", "reached", '"reached"')
    assert Reason("no_path") is Reason.no_path
    assert pickle.loads(pickle.dumps(Reason.lost)) is Reason.lost
    assert threewe.SensorType.lidar == "lidar"


def test_arrays_of_values(values: list[Any]) -> None:
    def first(kind: type[Any]) -> Any:
        return next(value for value in values if isinstance(value, kind))

    pose, scan, grid = Pose2D(1, 2, 0.5), first(threewe.LaserScan), first(threewe.OccupancyGrid)
    assert np.asarray(pose).tolist() == [1.0, 2.0, 0.5]
    assert np.asarray(pose).dtype == np.float64
    assert np.asarray([pose, pose]).shape == (2, 3)
    assert np.asarray(Velocity(0.1, 0.2, 0.3), np.float32).dtype == np.float32
    assert len(pose) == len(Velocity()) == 3
    with pytest.raises(ValueError, match="avoid copy"):
        np.array(pose, copy=False)
    assert np.shares_memory(np.asarray(scan), scan.ranges)
    assert np.asarray(scan).dtype == np.float32
    assert not np.shares_memory(np.array(scan), scan.ranges)
    assert len(scan) == len(scan.ranges)
    assert list(scan) == scan.ranges.tolist()
    assert np.shares_memory(np.asarray(grid), grid.data)
    for several in (threewe.RGBDImage, threewe.SemanticImage, threewe.IMUData, threewe.Odometry):
        with pytest.raises(TypeError, match="holds several arrays: take `"):
            np.asarray(first(several))


async def test_poses_where_numbers_are_wanted() -> None:
    async with Robot(scene="corridor_v1", noise="ideal") as robot:
        path = [Pose2D(0.3, 0.0, 1.0), (0.6, 0.0)]
        assert (await robot.follow_path(path)).reason == "reached"
        with pytest.raises(ContractError, match=r"path\[1\] must"):
            await robot.follow_path([Pose2D(), "x"])  # type: ignore[list-item]
        assert robot.simulation is not None
        assert robot.simulation.geodesic(Pose2D(), (1.0, 0.0)) == robot.simulation.geodesic((0, 0), (1, 0))


async def test_observations_have_the_types_that_environments_have() -> None:
    async with Robot(hardware="3we_depth_v2", scene="corridor_v1") as robot:
        types = {name: array.dtype for name, array in robot.get_observation().items()}
    assert types.pop("image") == np.uint8
    assert set(types.values()) == {np.dtype(np.float32)}


@pytest.mark.parametrize(
    ("make", "hint"),
    [
        (lambda: Robot(robots=["3we_standard_v2"]), r"several in one world are a World\(robots=\[\.\.\.\]\)"),
        (lambda: Robot(hardware=["3we_standard_v2"] * 2), r"several in one world are a World\(robots=\[\.\.\.\]\)"),
        (lambda: threewe.World(hardware="3we_standard_v2"), r"a World has `robots`, one hardware profile for each"),
        (lambda: threewe.World(viewer="web"), "viewer is an option of Robot, and a World has none"),
    ],
)
def test_options_of_robots_and_worlds(make: Callable[[], object], hint: str) -> None:
    with pytest.raises(threewe.ThreeweError, match=hint):
        make()
