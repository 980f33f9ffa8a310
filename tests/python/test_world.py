"""Several robots in one world, and the people in it."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path

import numpy as np
import pytest
import threewe
import threewe.sync
from threewe import ConfigError, Pose2D, Robot, World

from verify.cases.doorways import two_rooms

HARDWARE = ("3we_standard_v2", "3we_depth_v2", "turtlebot_like")
IN_RECEIVING = (Pose2D(0.0, 0.0, 0.0), Pose2D(1.5, 0.0, 3.0), Pose2D(0.7, 1.3, -1.5))


def range_towards(robot: Robot, other: Robot) -> tuple[float, float]:
    """What the lidar says in the direction of another robot's middle, and how far that is [m]."""
    assert robot.simulation is not None
    assert other.simulation is not None
    assert robot.profile.lidar is not None
    lidar = robot.simulation.true_pose() * robot.get_transform("base", "lidar")
    x, y = lidar.inverse().transform((other.simulation.true_pose().x, other.simulation.true_pose().y))
    scan = robot.get_lidar_scan()
    beam = round((math.atan2(y, x) - scan.angle_min) / scan.angle_increment) % len(scan.ranges)
    return float(scan.ranges[beam]), math.hypot(x, y)


async def test_three_robots_of_different_hardware_see_one_another_where_they_are_tall_enough() -> None:
    async with World(scene="warehouse_v1", robots=HARDWARE, start_poses=IN_RECEIVING, noise="ideal") as world:
        standard, depth, turtlebot = world.robots
        for robot in (standard, depth):
            for other in world.robots:
                if other is robot:
                    continue
                seen, away = range_towards(robot, other)
                assert away - other.profile.footprint_radius - 0.02 < seen < away
        # the turtlebot's lidar stands higher than both of them
        for other in (standard, depth):
            seen, away = range_towards(turtlebot, other)
            assert seen > away + 0.2


async def test_a_robot_that_drives_pays_for_it_and_the_others_stand_still() -> None:
    async with World(scene="warehouse_v1", robots=HARDWARE) as world:
        driver, *others = world.robots

        async def spent_in(seconds: float) -> np.ndarray:
            before = [robot.get_battery_state().charge for robot in world.robots]
            await world.sleep(seconds)
            after = [robot.get_battery_state().charge for robot in world.robots]
            return np.array(before) - np.array(after)

        standing = await spent_in(4.0)
        driver.set_velocity(0.5, hold=4.0)
        driving = await spent_in(4.0)
        assert np.all(standing > 0.0)
        assert driving[0] > 1.02 * standing[0]
        np.testing.assert_allclose(driving[1:], standing[1:], rtol=0.01)
        assert driver.simulation is not None
        assert driver.simulation.distance_driven() > 1.5
        assert all(robot.simulation is not None and robot.simulation.distance_driven() < 1e-6 for robot in others)


async def test_every_robot_of_a_world_has_noise_of_its_own() -> None:
    twins = ["3we_standard_v2", "3we_standard_v2"]
    async with World(scene="warehouse_v1", robots=twins, seed=5) as world, Robot(scene="warehouse_v1", seed=5) as alone:
        await world.sleep(3.0 - world.now)
        await alone.sleep(3.0 - alone.now)
        first, second = (robot.get_imu().linear_acceleration for robot in world.robots)
        assert not np.array_equal(first, second)
        np.testing.assert_array_equal(first, alone.get_imu().linear_acceleration)  # it does not notice the other


def test_a_robot_cannot_start_on_another() -> None:
    with pytest.raises(ConfigError, match=r"start pose 1: .* overlaps robot 0"):
        World(scene="warehouse_v1", start_poses=[(0.0, 0.0, 0.0), (0.15, 0.0, 1.0)])


async def test_resetting_one_robot_onto_another_is_refused_and_changes_nothing() -> None:
    async with World(scene="warehouse_v1", robots=HARDWARE, start_poses=IN_RECEIVING) as world:
        truth = world.robots[0].simulation
        assert truth is not None
        with pytest.raises(ConfigError, match="overlaps robot 0"):
            truth.reset(pose=(1.5, 0.1, 0.0))
        assert truth.true_pose() == IN_RECEIVING[0]


def places(robot: Robot) -> dict[str, Pose2D]:
    """Where everybody is."""
    assert robot.simulation is not None
    return {person.name: person.pose for person in robot.simulation.people()}


async def test_people_walk_their_routes_and_come_back_with_a_snapshot() -> None:
    async with Robot(scene="dynamic_v1", seed=2) as robot:
        truth = robot.simulation
        assert truth is not None
        assert list(places(robot)) == [person.name for person in truth.scene.people]
        snapshot, before = truth.save(), places(robot)
        await robot.sleep(5.0)
        later = places(robot)
        assert later != before
        truth.restore(snapshot)
        assert places(robot) == before
        await robot.sleep(5.0)
        assert places(robot) == later
        truth.reset(seed=3)
        assert places(robot) != before
        truth.reset(seed=2)
        assert places(robot) == before
    assert "people" not in dir(robot)  # truth only


async def test_a_person_waits_for_a_robot_in_the_way_and_is_seen_and_heard() -> None:
    visitor = threewe.Scene.load("dynamic_v1").people[0]
    (ax, ay), (bx, by) = visitor.route[:2]
    in_the_way = Pose2D((ax + bx) / 2, (ay + by) / 2, math.atan2(ay - by, ax - bx))
    async with Robot(scene="dynamic_v1", seed=2, start_pose=in_the_way, noise="ideal") as robot:
        truth = robot.simulation
        assert truth is not None
        await robot.sleep(40.0)
        [waiting] = [person for person in truth.people() if person.name == visitor.name]
        await robot.sleep(3.0)
        assert places(robot)[visitor.name] == waiting.pose
        ahead = math.hypot(waiting.pose.x - in_the_way.x, waiting.pose.y - in_the_way.y)
        assert ahead == pytest.approx(1.0, abs=0.02)
        leg = robot.get_lidar_scan().ranges[165:195].min()
        assert ahead - 0.04 - waiting.radius < leg < ahead - 0.04 + waiting.radius
        assert robot.get_ultrasonic_ranges()["ultrasonic_front_left"].range < ahead - 0.1
        assert truth.true_pose() == in_the_way
        assert truth.max_collision_speed() == 0.0


def test_people_in_a_script() -> None:
    with threewe.sync.Robot(scene="dynamic_v1") as robot:
        assert robot.simulation is not None
        person = robot.simulation.people()[0]
        assert person.radius > 0.0
        assert person.name in repr(person)


async def test_robots_connect_all_at_once() -> None:
    async with Robot(scene="warehouse_v1") as robot:
        alone = robot.now
    async with World(scene="warehouse_v1", robots=HARDWARE) as world:
        assert world.now == pytest.approx(alone, abs=0.1)
        assert all(robot.get_battery_state().charge > 0.9 for robot in world.robots)


SWAPS = [(True, 0), (True, 25), (True, 28), (False, 2), (False, 7), (False, 11)]


@pytest.mark.parametrize(("share_a_map_frame", "seed"), SWAPS)
async def test_robots_that_swap_through_a_passage_do_not_take_each_other_for_walls(
    share_a_map_frame: bool, seed: int, tmp_path: Path
) -> None:
    scene = tmp_path / "passage.yaml"
    scene.write_text(two_rooms(scene.stem, 0.6, np.random.default_rng(seed)))
    starts = [Pose2D(-1.0, 0.0, 0.0), Pose2D(5.0, 0.0, math.pi)]
    goals = [Pose2D(5.0, 0.3, 0.0), Pose2D(-1.0, 0.3, 0.0)]
    initial_poses = starts if share_a_map_frame else []
    robots = ["3we_standard_v2"] * 2
    async with World(
        scene=str(scene), seed=seed, robots=robots, start_poses=starts, initial_poses=initial_poses
    ) as world:
        if not share_a_map_frame:
            goals = [start.inverse() * goal for start, goal in zip(starts, goals, strict=True)]
        motions = [robot.move_to(goal.x, goal.y) for robot, goal in zip(world.robots, goals, strict=True)]
        for robot, result in zip(world.robots, await asyncio.gather(*motions), strict=True):
            assert result.reason == "reached" or (result.reason == "blocked" and " at (" in result.detail), result
            assert robot.simulation is not None
            assert robot.simulation.max_collision_speed() <= 0.05
