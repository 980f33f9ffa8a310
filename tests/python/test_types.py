"""The data that users hold in their hands: right shapes, right numbers, and never a dangling view."""

from __future__ import annotations

import gc
import math
import weakref

import numpy as np
import pytest
import threewe
from threewe import ContractError, LaserScan, OccupancyGrid, Pose2D, Velocity


def matrix(pose: Pose2D) -> np.ndarray:
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    return np.array([[c, -s, pose.x], [s, c, pose.y], [0.0, 0.0, 1.0]])


def random_poses(seed: int, count: int) -> list[Pose2D]:
    random = np.random.default_rng(seed)
    return [Pose2D(*random.uniform(-5, 5, 3)) for _ in range(count)]


def test_poses_compose_as_matrices_do() -> None:
    for a, b in zip(random_poses(1, 200), random_poses(2, 200), strict=True):
        np.testing.assert_allclose(matrix(a * b), matrix(a) @ matrix(b), atol=1e-12)
        np.testing.assert_allclose(matrix(a.inverse()), np.linalg.inv(matrix(a)), atol=1e-12)
        np.testing.assert_allclose(a.transform((b.x, b.y)), (matrix(a) @ [b.x, b.y, 1.0])[:2], atol=1e-12)
        assert a.distance(b) == pytest.approx(math.hypot(a.x - b.x, a.y - b.y))


@pytest.mark.parametrize(("given", "wrapped"), [(math.pi, math.pi), (-math.pi, math.pi), (7.0, 7.0 - 2 * math.pi)])
def test_headings_are_wrapped(given: float, wrapped: float) -> None:
    assert Pose2D(theta=given).theta == pytest.approx(wrapped, abs=1e-12)


@pytest.mark.parametrize("heading", [math.nan, math.inf, -math.inf])
def test_a_heading_that_is_no_number_stays_none(heading: float) -> None:
    assert math.isnan(Pose2D(theta=heading).theta)


def test_poses_and_velocities_unpack_compare_and_print() -> None:
    x, y, theta = Pose2D(1.0, 2.0, 0.5)
    assert (x, y, theta) == (1.0, 2.0, 0.5)
    assert Pose2D(1.0, 2.0) == Pose2D(1.0, 2.0) != Pose2D(1.0, 2.1)
    assert Pose2D() != Velocity()
    assert len({Pose2D(), Pose2D(), Pose2D(1.0)}) == 2
    assert repr(Pose2D(1.0, -2.0, 0.5)) == "Pose2D(x=1.000, y=-2.000, theta=0.500)"
    assert list(Velocity(0.1, 0.2, 0.3)) == [0.1, 0.2, 0.3]
    with pytest.raises(AttributeError):
        Pose2D().x = 1.0  # type: ignore[misc]


def test_a_scan_is_a_float32_array_that_outlives_its_scan() -> None:
    given = np.linspace(0.0, 12.0, 360, dtype=np.float32)
    scan = LaserScan(given, 0.0, math.tau / 360, 0.02, 12.0)
    ranges = scan.ranges
    given[:] = -1.0  # the scan has its own copy
    del scan
    gc.collect()
    assert ranges.dtype == np.float32
    assert ranges.shape == (360,)
    assert not ranges.flags.writeable
    np.testing.assert_array_equal(ranges, np.linspace(0.0, 12.0, 360, dtype=np.float32))


def test_a_map_is_an_int8_array_that_outlives_its_map() -> None:
    cells = np.random.default_rng(3).integers(-1, 101, (30, 40), dtype=np.int8)
    grid = OccupancyGrid(cells, 0.1, (-1.0, 2.0))
    data = grid.data
    assert (grid.height, grid.width) == data.shape == (30, 40)
    assert grid.origin == (-1.0, 2.0)
    for row, column in [(0, 0), (29, 39), (7, 20)]:
        point = (-1.0 + 0.1 * (column + 0.5), 2.0 + 0.1 * (row + 0.5))
        assert grid.cell(point) == (row, column)
        assert grid.at(point) == cells[row, column]
    assert grid.at((1e3, 0.0)) == -1
    del grid
    gc.collect()
    assert data.dtype == np.int8
    assert not data.flags.writeable
    np.testing.assert_array_equal(data, cells)


def test_wrong_arrays_are_refused() -> None:
    with pytest.raises(
        ContractError, match=r"ranges must be a float32 array of shape \(\*\), and the array given differs"
    ):
        LaserScan(np.zeros((3, 3), np.float32), 0.0, 0.1, 0.0, 1.0)  # type: ignore[arg-type]
    with pytest.raises(ContractError, match=r"data must be an int8 array of shape \(\*, \*\), and the array given"):
        OccupancyGrid(np.zeros(3, np.int8))  # type: ignore[arg-type]


def test_scenes_are_data() -> None:
    scene = threewe.Scene.load("office_v2")
    walls, room = scene.walls, scene.room("kitchen")
    assert scene.room_at(room.anchor) is not None
    assert scene.room_at(room.anchor).name == "kitchen"  # type: ignore[union-attr]
    assert scene.room_at((1e3, 0.0)) is None
    assert {thing.category for thing in scene.objects} >= {"chair", "desk", "shelf"}
    outline = scene.objects[0].prisms[0].outline()
    assert len(outline) in (4, 24)
    del scene
    gc.collect()
    assert len(walls[0].a) == 2
    assert room.name == "kitchen"


@pytest.mark.parametrize("name", threewe.profile_names())
def test_profiles_are_data(name: str) -> None:
    profile = threewe.RobotProfile.load(name)
    limits, lidar = profile.operating_limits, profile.lidar
    assert profile.name == name
    assert limits.linear > 0.0
    corners = np.array(profile.footprint)
    assert np.hypot(*corners.T).max() == pytest.approx(profile.footprint_radius)
    del profile
    gc.collect()
    assert limits.angular > 0.0
    assert lidar is None or lidar.range_max > 0.0


async def test_ultrasonic_ranges_go_by_the_names_of_their_sensors() -> None:
    async with threewe.Robot(hardware="3we_base_v2", scene="corridor_v1", noise="ideal") as robot:
        ranges = robot.get_ultrasonic_ranges()
        assert set(ranges) == {f"ultrasonic_{place}" for place in ("front_left", "front_right", "left", "right")}
        left = ranges["ultrasonic_left"]
        assert left.range_min < left.range < left.range_max  # the wall of the corridor
        robot.set_velocity(vy=0.2, hold=2.0)
        await robot.sleep(2.0)
        nearer = robot.get_ultrasonic_ranges()["ultrasonic_left"]
        assert nearer.range == pytest.approx(left.range - robot.get_odometry().pose.y, abs=0.05)
    async with threewe.Robot(hardware="turtlebot_like", scene="corridor_v1") as robot:
        with pytest.raises(threewe.HardwareError, match="'turtlebot_like' has no sensor 'ultrasonic'"):
            robot.get_ultrasonic_ranges()


async def test_what_a_robot_without_a_lidar_cannot_do_names_the_sensor() -> None:
    async with threewe.Robot(hardware="3we_base_v2", scene="corridor_v1") as robot:
        for missing in (robot.get_lidar_scan, robot.get_map):
            with pytest.raises(threewe.HardwareError, match="'3we_base_v2' has no sensor 'lidar'"):
                missing()
        with pytest.raises(threewe.HardwareError, match="'3we_base_v2' has no sensor 'lidar', which exploring needs"):
            await robot.explore()


async def test_readings_are_arrays_that_stay_as_they_were(robot: threewe.Robot) -> None:
    scan, imu, odometry, battery = (
        robot.get_lidar_scan(),
        robot.get_imu(),
        robot.get_odometry(),
        robot.get_battery_state(),
    )
    before = scan.ranges.copy()
    robot.set_velocity(omega=1.0)
    await robot.sleep(0.4)
    np.testing.assert_array_equal(scan.ranges, before)
    assert not np.array_equal(robot.get_lidar_scan().ranges, before)
    assert scan.ranges.shape == (360,)
    assert imu.angular_velocity.shape == imu.linear_acceleration.shape == (3,)
    assert imu.linear_acceleration[2] == pytest.approx(9.81, abs=0.1)
    assert odometry.pose == Pose2D()
    assert 0.0 < battery.charge <= 1.0
    assert robot.get_observation()["lidar"].dtype == np.float32
    for reading in (scan, imu, odometry, battery, robot.get_map()):
        assert repr(reading).startswith(type(reading).__name__)


async def test_the_map_is_the_same_object_until_it_changes(robot: threewe.Robot) -> None:
    first = robot.get_map()
    assert robot.get_map() is first
    cells = first.data.copy()
    await robot.rotate(1.0)
    assert robot.get_map() is not first
    np.testing.assert_array_equal(first.data, cells)


def test_observers_that_know_their_robot_do_not_keep_it_alive() -> None:
    def watched_robot() -> weakref.ref[threewe.Robot]:
        robot = threewe.Robot(scene="corridor_v1", noise="ideal")
        robot.observe(lambda tick: print(robot, tick))
        return weakref.ref(robot)

    reference = watched_robot()
    gc.collect()
    assert reference() is None


def test_a_scene_outlives_its_robot() -> None:
    robot = threewe.Robot(scene="corridor_v1", noise="ideal")
    assert robot.simulation is not None
    scene = robot.simulation.scene
    del robot
    gc.collect()
    assert scene.room(scene.rooms[0].name).anchor
