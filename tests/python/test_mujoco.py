"""Robots on MuJoCo's physics, as users see them."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import gymnasium
import numpy as np
import pytest
import threewe
import threewe.sync
from threewe.testing import check_backend

WITHOUT_MUJOCO = """
import importlib.util
import threewe
found = importlib.util.find_spec
importlib.util.find_spec = lambda name, *rest: None if name == "mujoco" else found(name, *rest)
try:
    threewe.Robot(backend="mujoco")
except threewe.ConfigError as error:
    print(error)
"""

needs_mujoco = pytest.mark.skipif(find_spec("mujoco") is None, reason="not shown: mujoco-core is not installed")


def test_without_mujoco_the_error_names_the_command() -> None:
    run = subprocess.run([sys.executable, "-c", WITHOUT_MUJOCO], capture_output=True, text=True, check=True)
    assert "pip install mujoco-core==4.0.0" in run.stdout


@needs_mujoco
def test_a_robot_drives_to_its_goal_in_the_office() -> None:
    with threewe.sync.Robot(backend="mujoco") as robot:
        result = robot.move_to(x=2.0, y=1.0)
        assert result.success
        assert robot.simulation is not None
        pose = robot.simulation.true_pose()
        assert (pose.x, pose.y) == pytest.approx((2.0, 1.0), abs=0.25)
        assert robot.simulation.max_collision_speed() == 0.0


@needs_mujoco
def test_every_kind_of_motion_works_and_a_map_is_used_again(tmp_path: Path) -> None:
    file = tmp_path / "apartment.yaml"
    with threewe.sync.Robot(backend="mujoco", scene="apartment_v1") as robot:
        assert robot.move_forward(0.3).success
        assert robot.rotate(1.0).success
        assert robot.follow_path([(0.5, 0.0), (0.8, 0.2)]).success
        assert robot.explore(timeout=5.0).reason is threewe.Reason.timeout
        assert robot.execute_action([0.5, 0.0, 0.0]).vx > 0.0
        assert len(robot.get_ultrasonic_ranges()) == 4
        robot.save_map(file)
    with threewe.sync.Robot(backend="mujoco", scene="apartment_v1", map=file) as robot:
        assert robot.move_to(x=0.5, y=0.3).success


@needs_mujoco
def test_an_emergency_stop_holds_it() -> None:
    with threewe.sync.Robot(backend="mujoco") as robot:
        robot.set_velocity(0.5, 0.0, 0.0, hold=1.0)
        robot.sleep(0.5)
        robot.emergency_stop()
        robot.sleep(0.5)
        assert robot.simulation is not None
        before = robot.simulation.true_pose()
        robot.sleep(1.0)
        after = robot.simulation.true_pose()
        assert (after.x, after.y) == pytest.approx((before.x, before.y), abs=1e-3)


@needs_mujoco
def test_learning_environments_run_on_it() -> None:
    env = gymnasium.make("3we/Navigation-v1", backend="mujoco", observations=("lidar", "goal"), lidar_beams=72)
    observation, _ = env.reset(seed=3)
    again, _ = env.reset(seed=3)
    assert np.array_equal(observation["lidar"], again["lidar"])
    moved = [env.step(np.array([1.0, 0.0, 0.0], np.float32))[0] for _ in range(10)][-1]
    assert not np.array_equal(moved["lidar"], observation["lidar"])
    env.close()


@needs_mujoco
def test_two_runs_are_the_same_and_mock_is_another() -> None:
    def end(backend: str) -> tuple[float, float, float]:
        with threewe.sync.Robot(backend=backend, seed=7) as robot:
            robot.move_to(x=1.0, y=0.5)
            assert robot.simulation is not None
            pose = robot.simulation.true_pose()
            return pose.x, pose.y, pose.theta

    first = end("mujoco")
    assert end("mujoco") == first
    assert end("mock") != first
    assert end("mock") == pytest.approx(first, abs=0.3)


@needs_mujoco
def test_a_camera_is_refused_by_name() -> None:
    with threewe.sync.Robot(backend="mujoco") as robot:
        with pytest.raises(threewe.HardwareError, match="this backend does not deliver sensor 'camera'"):
            robot.get_camera_image()
        assert robot.simulation is not None
        with pytest.raises(threewe.HardwareError, match="'mujoco' draws no pictures yet"):
            robot.simulation.look()


@needs_mujoco
def test_the_contract_is_kept_by_name() -> None:
    (result,) = check_backend("mujoco", checks=["truth_agrees_with_odometry"], show=False)
    assert result.passed, result.detail
