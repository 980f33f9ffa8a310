"""Distance between a robot's body and what its sensors see."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from threewe._core import SensorType
from threewe.robot import Robot


def nearest_obstacle(robot: Robot) -> tuple[float, float] | None:
    """Distance [m] from the outline of the robot to the nearest return, and its bearing [rad] from `base`.

    It takes the newest scan of the lidar, or the ultrasonic sensors where the robot has none. None where nothing is
    within reach.
    """
    points = obstacle_points(robot)
    if not len(points):
        return None
    distances = distances_to_outline(points, np.array(robot.profile.footprint))
    nearest = int(distances.argmin())
    return float(distances[nearest]), math.atan2(points[nearest, 1], points[nearest, 0])


def obstacle_points(robot: Robot) -> NDArray[np.float64]:
    """Returns (N, 2) [m] of the newest lidar scan in `base`, or of the ultrasonic sensors where there is no lidar."""
    return _ultrasonic_points(robot) if robot.profile.lidar is None else _lidar_points(robot)


def distances_to_outline(points: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distances (N,) [m] of points (N, 2) to a convex outline, counter-clockwise (K, 2); 0 inside."""
    starts, ends = outline, np.roll(outline, -1, axis=0)
    edges = ends - starts  # (K, 2)
    offsets = points[:, None] - starts  # (N, K, 2)
    along = (offsets * edges).sum(-1) / np.maximum((edges * edges).sum(-1), 1e-12)
    gaps = offsets - np.clip(along, 0.0, 1.0)[..., None] * edges
    outside = (edges[:, 0] * offsets[..., 1] - edges[:, 1] * offsets[..., 0] < 0.0).any(-1)
    distances: NDArray[np.float64] = np.where(outside, np.hypot(gaps[..., 0], gaps[..., 1]).min(-1), 0.0)
    return distances


def _lidar_points(robot: Robot) -> NDArray[np.float64]:
    """(N, 2) [m] in `base`."""
    scan = robot.get_lidar_scan()
    ranges = np.asarray(scan.ranges, np.float64)
    valid = (ranges > 0.0) & (ranges < scan.range_max)
    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    base_from_lidar = robot.get_transform("base", "lidar")
    angles, ranges = angles[valid] + base_from_lidar.theta, ranges[valid]
    return np.column_stack([base_from_lidar.x + ranges * np.cos(angles), base_from_lidar.y + ranges * np.sin(angles)])


def _ultrasonic_points(robot: Robot) -> NDArray[np.float64]:
    """(N, 2) [m] in `base`: on the axes of the cones."""
    points = []
    if any(sensor.type is SensorType.ultrasonic for sensor in robot.features.sensors):
        for name, reading in robot.get_ultrasonic_ranges().items():
            if 0.0 < reading.range < reading.range_max:
                mount = robot.get_transform("base", name)
                ahead = mount.x + reading.range * math.cos(mount.theta)
                points.append((ahead, mount.y + reading.range * math.sin(mount.theta)))
    return np.array(points).reshape(-1, 2)
