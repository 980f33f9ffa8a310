"""Robots on MuJoCo's physics, as users see them."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import command_line
import gymnasium
import numpy as np
import pytest
import threewe
import threewe.sync
from threewe.gym import TASKS
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

WITHOUT_A_RENDERER = """
import threewe, threewe.sync
with threewe.sync.Robot(backend="mujoco") as robot:
    assert robot.move_forward(0.2).success, "nobody looks, so nothing is drawn"
    try:
        robot.get_camera_image()
    except threewe.HardwareError as error:
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
@pytest.mark.parametrize("task", TASKS)
def test_learning_environments_run_on_it_and_repeat(task: str) -> None:
    env = gymnasium.make(f"3we/{task}-v1", backend="mujoco")

    def episode(seed: int) -> list[bytes]:
        observation, _ = env.reset(seed=seed)
        seen = [observation]
        for action in ([1.0, 0.0, 0.5], [1.0, 0.5, 0.0], [0.0, 0.0, -1.0]):
            padded = np.zeros(env.action_space.shape or (), np.float32)
            padded[:3] = action
            seen.append(env.step(padded)[0])
        return [values[key].tobytes() for values in seen for key in sorted(values)]

    first = episode(3)
    assert episode(4) != first
    assert episode(3) == first
    env.close()


@needs_mujoco
@pytest.mark.parametrize("arguments", [["drive", "--to", "1", "0.5"], ["explore", "--seconds", "5"]])
def test_the_command_line_drives_it(arguments: list[str]) -> None:
    run = command_line.threewe(*arguments, "--backend", "mujoco", "--scene", "apartment_v1")
    assert run.stdout.startswith(("reached", "timeout")), run.stderr
    assert "m driven in" in run.stdout


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
def test_cameras_see_what_the_embedded_ones_see() -> None:
    seen = {}
    for backend in ("mujoco", "mock"):
        with threewe.sync.Robot(backend=backend, hardware="3we_depth_v2", noise="ideal") as robot:
            robot.sleep(0.5)
            assert robot.simulation is not None
            seen[backend] = (robot.get_rgbd_image(), robot.simulation.look())
    (ours, truth), (expected, embedded) = seen["mujoco"], seen["mock"]
    assert ours.color.shape == (480, 640, 3)
    assert truth.names == embedded.names
    assert np.mean(truth.ids == embedded.ids) > 0.99
    assert np.mean(np.abs(truth.depth - embedded.depth) <= np.maximum(0.02, 0.01 * embedded.depth)) > 0.99
    assert np.mean(ours.depth == 0.0) == pytest.approx(np.mean(expected.depth == 0.0), abs=0.01)
    difference = ours.color.astype(float).mean((0, 1)) - expected.color.astype(float).mean((0, 1))
    assert np.abs(difference).max() < 40.0, "blue, green and red are about as bright"


@needs_mujoco
@pytest.mark.parametrize("lacks", ["the library", "a driver"])
def test_without_a_renderer_the_error_names_the_command(lacks: str, tmp_path: Path) -> None:
    (tmp_path / "libEGL.so.1").write_text("no library")
    where = {
        "the library": {"LD_LIBRARY_PATH": str(tmp_path)},
        "a driver": {"__EGL_VENDOR_LIBRARY_FILENAMES": str(tmp_path / "none.json")},
    }[lacks]
    command = [sys.executable, "-c", WITHOUT_A_RENDERER]
    run = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **where})
    assert "apt-get install libegl1 libgl1-mesa-dri" in run.stdout, run.stderr


@needs_mujoco
async def test_several_robots_and_people_share_a_world() -> None:
    starts = [(0.0, 0.0, 0.0), (0.0, 0.6, 0.0)]
    async with threewe.World(backend="mujoco", scene="dynamic_v1", start_poses=starts) as world:
        first, second = world.robots
        assert (await first.move_forward(0.3)).success
        assert first.simulation is not None
        assert second.simulation is not None
        assert len(first.simulation.people()) == 8
        assert second.simulation.distance_driven() < 0.01


@needs_mujoco
def test_the_contract_is_kept_by_name() -> None:
    (result,) = check_backend("mujoco", checks=["truth_agrees_with_odometry"], show=False)
    assert result.passed, result.detail
