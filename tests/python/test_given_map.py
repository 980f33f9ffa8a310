"""A robot in a given map: it finds itself, notices when it was carried away, and saves what it knows."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path

import numpy as np
import pytest
import threewe
from threewe import (
    ConfigError,
    ContractError,
    HardwareError,
    LocalizationState,
    OccupancyGrid,
    Pose2D,
    Reason,
    Robot,
    World,
)
from threewe.slam import load_map
from threewe.sync import Robot as BlockingRobot


@pytest.fixture(scope="module")
def apartment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The map that a robot has drawn of apartment_v1, whose frame is the scene's."""
    path = tmp_path_factory.mktemp("maps") / "apartment.yaml"
    with BlockingRobot(scene="apartment_v1", seed=1) as robot:
        assert robot.explore()
        robot.save_map(path)
    return path


def error(robot: Robot) -> float:
    assert robot.simulation is not None
    return robot.get_pose().distance(robot.simulation.true_pose())


async def test_a_robot_finds_itself_and_drives(apartment: Path) -> None:
    kitchen = threewe.Scene.load("apartment_v1").room("kitchen").anchor
    async with Robot(scene="apartment_v1", map=apartment, start_pose=(2.0, 1.0, 2.0), seed=5) as robot:
        assert robot.localization_state == LocalizationState.lost
        await robot.sleep(1.0)
        assert not robot.lost
        assert robot.localization_state == LocalizationState.tracking
        assert error(robot) < 0.1
        assert robot.simulation is not None
        assert robot.simulation.scene_from_map == Pose2D()
        result = await robot.move_to(*kitchen)
        assert result.success
        assert math.dist(kitchen, (robot.simulation.true_pose().x, robot.simulation.true_pose().y)) < 0.25


async def test_a_motion_waits_until_the_robot_has_found_itself(apartment: Path) -> None:
    async with Robot(scene="apartment_v1", map=load_map(apartment), start_pose=(2.0, 1.0, 2.0)) as robot:
        assert robot.lost
        assert (await robot.move_to(0.5, 0.0)).success
        assert error(robot) < 0.1


async def test_a_robot_that_is_carried_away_in_the_middle_of_a_drive_arrives(apartment: Path) -> None:
    kitchen = threewe.Scene.load("apartment_v1").room("kitchen").anchor
    async with Robot(scene="apartment_v1", map=apartment, initial_pose=(0.0, 0.0, 0.0), seed=2) as robot:
        assert robot.simulation is not None
        assert not robot.lost
        drive = asyncio.create_task(robot.move_to(*kitchen, timeout=120.0))
        await robot.sleep(2.0)
        robot.simulation.teleport((2.0, 1.0, 2.0))
        await robot.sleep(1.4)
        assert robot.lost or error(robot) < 0.15  # it knows by then, or has found itself
        assert (await drive).success
        assert error(robot) < 0.15


async def test_a_robot_in_a_map_of_another_place_stays_lost(apartment: Path) -> None:
    async with Robot(scene="warehouse_v1", map=apartment) as robot:
        result = await robot.move_to(2.0, 1.0)
        assert (result.success, result.reason) == (False, Reason.lost)
        assert "no place in the map" in result.detail
        assert robot.lost
        assert (await robot.rotate(1.0)).success  # needs no place


async def test_a_run_in_a_map_repeats_to_the_bit(apartment: Path) -> None:
    async def live() -> list[object]:
        async with Robot(scene="apartment_v1", map=apartment, start_pose=(2.0, 1.0, 2.0), seed=3) as robot:
            await robot.move_to(0.5, 0.0)
            return [robot.now, robot.get_pose(), robot.get_map().data.tobytes()]

    assert await live() == await live()


async def test_a_moment_of_being_lost_can_be_lived_again(apartment: Path) -> None:
    async with Robot(scene="apartment_v1", map=apartment, start_pose=(2.0, 1.0, 2.0), seed=3) as robot:
        assert robot.simulation is not None
        assert robot.lost
        moment = robot.simulation.save()
        await robot.sleep(1.0)
        first = robot.get_pose()
        robot.simulation.restore(moment)
        assert robot.lost
        await robot.sleep(1.0)
        assert robot.get_pose() == first
        robot.simulation.reset()
        assert robot.lost


async def test_robots_of_one_world_share_a_map(apartment: Path) -> None:
    starts = [(2.0, 1.0, 2.0), (0.0, 0.0, 0.0)]
    async with World(scene="apartment_v1", start_poses=starts, initial_poses=starts[:1], map=apartment) as world:
        one, two = world.robots
        assert not one.lost
        await world.sleep(1.0)
        assert not two.lost
        assert error(two) < 0.1


async def test_a_saved_map_is_the_map(apartment: Path, tmp_path: Path) -> None:
    before = load_map(apartment)
    async with Robot(scene="apartment_v1", map=before, initial_pose=(0.0, 0.0, 0.0), noise="ideal") as robot:
        await robot.sleep(1.0)
        robot.save_map(tmp_path / "again.yaml")
    after = load_map(tmp_path / "again.yaml")
    assert (after.data.shape, after.origin) == (before.data.shape, before.origin)
    assert np.mean(after.data == before.data) > 0.99


def test_wrong_maps_are_one_error(apartment: Path, tmp_path: Path) -> None:
    crooked = tmp_path / "crooked.yaml"
    crooked.write_text(apartment.read_text().replace(", 0]", ", 0.5]").replace("apartment.pgm", str(apartment)))
    with pytest.raises(ConfigError, match=r"crooked\.yaml:4: origin\[2\]: only maps along the axes"):
        Robot(map=crooked)
    with pytest.raises(ConfigError, match=r"nowhere\.yaml: cannot be read"):
        Robot(map="nowhere.yaml")
    with pytest.raises(ContractError, match="map must be an OccupancyGrid or the path"):
        Robot(map=3)  # type: ignore[arg-type]
    with pytest.raises(ContractError, match=r"map: resolution must lie in \[0.001, 10\] m"):
        Robot(map=OccupancyGrid(np.zeros((2, 2), np.int8), resolution=-0.1))
    with pytest.raises(ContractError, match="map must have cells"):
        Robot(map=OccupancyGrid(np.zeros((0, 0), np.int8)))
    with pytest.raises(HardwareError, match="no sensor 'lidar'"):
        Robot(hardware="3we_base_v2", map=apartment)
    with pytest.raises(ContractError, match="needs initial_pose"):
        Robot(map=apartment, localization="truth")


async def test_nobody_is_carried_into_a_wall() -> None:
    wall = threewe.Scene.load("apartment_v1").walls[0]
    async with Robot(scene="apartment_v1") as robot:
        assert robot.simulation is not None
        with pytest.raises(ConfigError, match="is inside a wall"):
            robot.simulation.teleport(((wall.a[0] + wall.b[0]) / 2, (wall.a[1] + wall.b[1]) / 2))
        with pytest.raises(ContractError, match="pose must"):
            robot.simulation.teleport("there")  # type: ignore[arg-type]
