"""What left the gate gives the same drive again, to the bit, without autonomy and gate above it."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest
from threewe import ContractError, Pose2D, Robot, RobotProfile, Scene, SceneTables
from threewe._core import DriveLog, Replay, RobotOptions
from threewe.gym import Env

PROFILE = RobotProfile.load("3we_standard_v2")


def same(again: Replay, log: DriveLog) -> bool:
    figures = (again.length, again.collision_speed) == (log.length, log.collision_speed)
    return np.array_equal(again.commands, log.commands) and np.array_equal(again.poses, log.poses) and figures


@pytest.mark.parametrize("scene", ["office_v2", "dynamic_v1"])
def test_a_robots_drive(scene: str) -> None:
    episode = SceneTables(Scene.load(scene), PROFILE).sample_episode(7, 1)
    robot = Robot(scene=scene, seed=episode.seed, start_pose=episode.start)
    log = DriveLog(robot._world)

    async def drive() -> None:
        goal = episode.start.inverse() * Pose2D(*episode.goal, 0.0)
        async with robot:
            await robot.move_to(goal.x, goal.y, timeout=8.0)
            log.end()
            await robot.sleep(0.2)

    asyncio.run(drive())
    assert 400 < len(log.commands) < 450, "what follows the end is not logged"
    again = Replay(RobotOptions(scene=scene, seed=episode.seed, start_pose=episode.start), log.commands)
    assert same(again, log)
    rounded = log.commands.astype(np.float32).astype(float)
    other = Replay(RobotOptions(scene=scene, seed=episode.seed, start_pose=episode.start), rounded)
    assert not np.array_equal(other.poses, log.poses), "single precision is not enough"


def test_each_episode_of_an_environment() -> None:
    tables = SceneTables(Scene.load("apartment_v1"), PROFILE)
    env = Env(task="navigation", scene="apartment_v1", backend="mock", observations=["goal"])
    log = DriveLog(env._core)
    for index in range(2):
        episode = tables.sample_episode(7, index)
        env.reset(seed=episode.seed, options={"start": tuple(episode.start), "goal": episode.goal})
        for _ in range(20):
            env.step(np.array([0.6, 0.2, 0.4], np.float32))
        again = Replay(RobotOptions(scene="apartment_v1", seed=episode.seed, start_pose=episode.start), log.commands)
        assert same(again, log)


def test_commands_that_no_base_can_drive_are_refused() -> None:
    with pytest.raises(ContractError, match="cannot drive sideways"):
        Replay(RobotOptions(hardware="turtlebot_like"), np.array([[0.1, 0.1, 0.0]]))
    with pytest.raises(ContractError, match="not finite"):
        Replay(RobotOptions(), np.array([[np.nan, 0.0, 0.0]]))


def test_contacts_are_counted_once_each() -> None:
    tables = SceneTables(Scene.load("office_v2"), PROFILE)
    ahead, back = [[0.5, 0.0, 0.0]] * 1000, [[-0.5, 0.0, 0.0]] * 50
    drive = Replay(RobotOptions(), np.array([*ahead, *back, *ahead]))
    assert drive.contacts(tables) == 2
    assert drive.collision_speed > 0.4
    assert Replay(RobotOptions(), np.zeros((50, 3))).contacts(tables) == 0
