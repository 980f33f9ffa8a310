"""Cameras: what a robot sees, and what is truly there."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threewe import CameraIntrinsics, ConfigError, HardwareError, Robot, asset_directories


def with_robot(use: Callable[[Robot], Awaitable[None]], hardware: str = "3we_depth_v2", noise: str = "ideal") -> None:
    """Runs `use` with a connected robot."""

    async def main() -> None:
        async with Robot(hardware=hardware, noise=noise) as robot:
            await use(robot)

    asyncio.run(main())


def test_image_is_bgr_and_ones_own() -> None:
    async def use(robot: Robot) -> None:
        image = robot.get_camera_image()
        assert image.shape == (480, 640, 3)
        assert image.dtype == np.uint8
        image[:] = 0  # does no harm to those who look after us
        assert robot.get_camera_image().any()
        assert np.array_equal(robot.get_camera_image(), robot.get_image("camera"))

    with_robot(use, hardware="3we_standard_v2")


def test_wood_is_brown_in_bgr() -> None:
    async def use(robot: Robot) -> None:
        assert robot.simulation is not None
        truth = robot.simulation.look()
        desk = truth.names.index("reception_desk")
        blue, green, red = robot.get_camera_image()[truth.ids == desk].mean(axis=0)
        assert red > green + 5
        assert green > blue + 5

    with_robot(use)


def test_ideal_depth_is_the_truth_within_range() -> None:
    async def use(robot: Robot) -> None:
        assert robot.simulation is not None
        image, truth = robot.get_rgbd_image(), robot.simulation.look()
        assert image.depth is not None
        assert image.depth.shape == (480, 640)
        assert robot.profile.camera is not None
        limits = robot.profile.camera.depth
        assert limits is not None
        within = (truth.depth >= limits.range_min) & (truth.depth <= limits.range_max)
        assert 0.3 < within.mean() < 1.0
        assert np.array_equal(image.depth, np.where(within, truth.depth, 0.0))
        assert np.array_equal(image.color, truth.color)
        with pytest.raises(ValueError, match="read-only"):
            image.depth[0, 0] = 1.0

    with_robot(use)


def test_realistic_noise_is_what_the_profile_says() -> None:
    async def use(robot: Robot) -> None:
        assert robot.simulation is not None
        truth = robot.simulation.look().color.astype(float)
        noise = (robot.get_camera_image() - truth)[(truth > 15) & (truth < 240)]
        assert abs(noise.mean()) < 0.05
        assert noise.std() == pytest.approx(3.0, abs=0.05)

    with_robot(use, noise="realistic")


def test_observation_has_what_the_robot_has() -> None:
    async def use(robot: Robot) -> None:
        observation = robot.get_observation()
        assert {name: array.shape for name, array in observation.items()} == {
            "pose": (3,),
            "velocity": (3,),
            "lidar": (360,),
            "ultrasonic": (4,),
            "image": (480, 640, 3),
            "depth": (480, 640),
        }

    with_robot(use)


def test_another_camera_looks_from_above() -> None:
    async def use(robot: Robot) -> None:
        assert robot.simulation is not None
        camera = CameraIntrinsics.of_view(160, 120, 1.0)
        for height in (0.1, 0.5):
            truth = robot.simulation.look(camera, (0.5, 0.0, 0.3), height)
            assert truth.ids.shape == (120, 160)
            assert truth.names[truth.ids[-1, 80]] == "floor"  # by similar triangles
            assert "robot_0" not in {truth.names[i] for i in np.unique(truth.ids)}
            assert truth.depth[-1, 80] == pytest.approx(height * camera.fy / 59.5, rel=1e-5)

    with_robot(use)


def test_missing_cameras_are_named() -> None:
    async def plain(robot: Robot) -> None:
        with pytest.raises(HardwareError, match="measures no depth; that of '3we_depth_v2' does"):
            robot.get_rgbd_image()
        with pytest.raises(HardwareError, match="fisheye"):
            robot.get_image("fisheye")

    async def blind(robot: Robot) -> None:
        assert robot.simulation is not None
        with pytest.raises(HardwareError, match="'turtlebot_like' has no sensor 'camera'"):
            robot.get_camera_image()
        with pytest.raises(HardwareError, match="has no camera: look"):
            robot.simulation.look()
        assert "image" not in robot.get_observation()

    with_robot(plain, hardware="3we_standard_v2")
    with_robot(blind, hardware="turtlebot_like")


@pytest.mark.parametrize(("width", "height"), [(0, 10), (10, 0), (1_000_000_000, 1), (100_000, 10_000), (-3, 5)])
def test_impossible_images_are_refused(width: int, height: int) -> None:
    with pytest.raises(ConfigError, match=f"{width} x {height} pixels: sides must be 1 to 16384"):
        CameraIntrinsics.of_view(width, height, 1.0)


@pytest.mark.parametrize(("field", "value"), [("width", 0), ("height", 1_000_000_000), ("horizontal_fov", 4.0)])
def test_impossible_cameras_in_a_profile_are_named_with_their_line(tmp_path: Path, field: str, value: float) -> None:
    robots = next(Path(folder) / "robots" for folder in asset_directories())
    lines = (robots / "3we_depth_v2.yaml").read_text().splitlines()
    line = next(i for i, text in enumerate(lines) if text.startswith(f"    {field}: "))
    lines[line] = f"    {field}: {value}"
    file = tmp_path / "mine.yaml"
    file.write_text("\n".join(lines))
    with pytest.raises(ConfigError, match=rf"mine\.yaml:{line + 1}: .*{field}"):
        Robot(hardware=file)


def test_look_takes_cameras_only() -> None:
    async def use(robot: Robot) -> None:
        assert robot.simulation is not None
        camera = CameraIntrinsics.of_view(16, 12, 1.0)
        for height in (0.0, -1.0):
            with pytest.raises(ConfigError, match="above the floor"):
                robot.simulation.look(camera, (0.0, 0.0, 0.0), height)

    with_robot(use)


def test_the_robot_is_in_sight_of_others_only() -> None:
    async def use(robot: Robot) -> None:
        truth = robot.simulation
        assert truth is not None
        behind = {"intrinsics": CameraIntrinsics.of_view(64, 48, 1.0), "pose": (-0.8, 0.0, 0.0), "height": 0.3}

        def seen(**options: Any) -> set[str]:
            image = truth.look(**options)
            return {image.names[i] for i in np.unique(image.ids)}

        assert "robot_0" in seen(**behind)
        assert "robot_0" not in seen(**behind, with_itself=False)
        assert "robot_0" not in seen()

    with_robot(use)
