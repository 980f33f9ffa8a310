"""A scene and a robot's body as the solids that Rerun draws."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from threewe import CameraIntrinsics, Pose2D, RobotProfile, Scene
from threewe import drawing as d
from threewe._core import Object, Patch, Room

SOLID = rr.components.FillMode.Solid
WALLS = (236, 234, 228)
SCAN_COLOR = (255, 200, 60, 255)
PERSON_HEIGHT = 1.75  # [m]
FLOOR_THICKNESS = 0.02  # [m], all of it below the floor

Box = tuple[Pose2D, float, float, float, float]  # pose of the middle, length, width, z_min, z_max [m]
Color = Sequence[int]
Drawn = tuple[str, rr.AsComponents]


def scene_solids(scene: Scene) -> Iterator[Drawn]:
    """(entity, what to log there), in the scene's frame: floors, walls and furniture."""
    yield "floor", _floors(scene)
    yield "walls", boxes([_wall(wall.a, wall.b, wall.thickness, wall.height) for wall in scene.walls], [WALLS])
    for thing in scene.objects:
        for archetype in object_solids(thing):
            yield f"objects/{thing.name}", archetype


def object_solids(thing: Object) -> Iterator[rr.AsComponents]:
    """The prisms of a piece of furniture: its boxes, then its cylinders."""
    color = [d.furniture_color(thing.category)]
    bars = [(thing.pose * p.pose, p.length, p.width, p.z_min, p.z_max) for p in thing.prisms if p.shape.name == "box"]
    if bars:
        yield boxes(bars, color)
    rods = [(thing.pose * p.pose, p.radius, p.z_min, p.z_max) for p in thing.prisms if p.shape.name == "cylinder"]
    if rods:
        yield rr.Cylinders3D(
            lengths=[high - low for _, _, low, high in rods],
            radii=[radius for _, radius, _, _ in rods],
            centers=[(pose.x, pose.y, (low + high) / 2) for pose, _, low, high in rods],
            colors=color,
            fill_mode=SOLID,
        )


def boxes(parts: Sequence[Box], colors: Sequence[Color]) -> rr.Boxes3D:
    """Solid boxes that stand upright: a colour for each, or one for all."""
    return rr.Boxes3D(
        centers=[(pose.x, pose.y, (low + high) / 2) for pose, _, _, low, high in parts],
        half_sizes=[(length / 2, width / 2, (high - low) / 2) for _, length, width, low, high in parts],
        quaternions=[(0.0, 0.0, math.sin(pose.theta / 2), math.cos(pose.theta / 2)) for pose, *_ in parts],
        colors=colors,
        fill_mode=SOLID,
    )


def body_mesh(profile: RobotProfile, color: Color) -> rr.Mesh3D:
    """A robot's outline, which is convex, from the floor to its height; in its base frame."""
    outline = profile.footprint
    n = len(outline)
    corners = [(x, y, z) for z in (0.0, profile.height) for x, y in outline]
    sides = [t for i in range(n) for j in [(i + 1) % n] for t in ((i, j, n + j), (i, n + j, n + i))]
    lid = [(n, n + i, n + i + 1) for i in range(1, n - 1)]
    return rr.Mesh3D(vertex_positions=corners, triangle_indices=[*sides, *lid], albedo_factor=color)


def body_outline(profile: RobotProfile, color: Color) -> rr.LineStrips3D:
    """The edges of a robot's body and an arrow ahead; in its base frame."""
    top = profile.height + 0.01
    ring = [*profile.footprint, profile.footprint[0]]
    r = profile.footprint_radius
    arrow = [(-0.3 * r, 0.4 * r), (0.62 * r, 0.0), (-0.3 * r, -0.4 * r)]
    strips = [
        *([(x, y, z) for x, y in ring] for z in (0.01, top)),
        *([(x, y, 0.01), (x, y, top)] for x, y in profile.footprint),
        [(x, y, top) for x, y in arrow],
    ]
    return rr.LineStrips3D([np.array(strip) for strip in strips], colors=[color], radii=0.008)


def figure(radius: float) -> rr.Capsules3D:
    """A person who stands at the origin."""
    return rr.Capsules3D(
        lengths=[PERSON_HEIGHT - 2 * radius],
        radii=[radius],
        translations=[(0.0, 0.0, radius)],
        colors=[d.ROUTE],
        fill_mode=SOLID,
    )


def transform(pose: Pose2D, height: float = 0.0) -> rr.Transform3D:
    """From what stands at a pose, so high [m]."""
    turn = rr.RotationAxisAngle(axis=(0.0, 0.0, 1.0), radians=pose.theta)
    return rr.Transform3D(translation=(pose.x, pose.y, height), rotation_axis_angle=turn)


def frustum(camera: CameraIntrinsics) -> rr.Pinhole:
    """How a camera that looks along x looks into space."""
    return rr.Pinhole(
        resolution=(camera.width, camera.height),
        focal_length=(camera.fx, camera.fy),
        principal_point=(camera.cx, camera.cy),
        camera_xyz=rr.ViewCoordinates.FLU,
        image_plane_distance=0.6,
    )


def scan_points(
    scan: tuple[NDArray[np.floating], NDArray[np.int64], float, float],
    base: tuple[NDArray[np.float64], ...],
    mount: Pose2D,
    height: float,
) -> rr.Points3D:
    """What a lidar hit.

    Args:
        scan: ranges [m], the (N,) beams that are drawn, angle_min and angle_increment [rad].
        base: x, y [m] and heading [rad] of the base when each of these beams was measured, (N,) each.
        mount: base_from_lidar.
        height: [m] of the lidar.
    """
    ranges, beams, angle_min, angle_increment = scan
    x, y, heading = base
    angles = heading + mount.theta + angle_min + beams * angle_increment
    c, s = np.cos(heading), np.sin(heading)
    points = np.stack(
        [
            x + c * mount.x - s * mount.y + ranges[beams] * np.cos(angles),
            y + s * mount.x + c * mount.y + ranges[beams] * np.sin(angles),
            np.full(len(beams), height),
        ],
        axis=1,
    )
    return rr.Points3D(points, colors=[SCAN_COLOR], radii=0.03)


def hits(ranges: NDArray[np.floating], range_max: float) -> NDArray[np.int64]:
    """The beams of a scan that came back."""
    return np.flatnonzero((ranges > 0.0) & (ranges < range_max))


def sonar_arc(sensor: Pose2D, height: float, distance: float, field_of_view: float) -> NDArray[np.float64]:
    """(9, 3): unknown is where in its cone the surface is."""
    angles = sensor.theta + np.linspace(-0.5, 0.5, 9) * field_of_view
    arc = [sensor.x + distance * np.cos(angles), sensor.y + distance * np.sin(angles), np.full(9, height)]
    return np.stack(arc, axis=1)


def _floors(scene: Scene) -> rr.Boxes3D:
    """Rooms, and patches of other floor a hair above them."""
    levels: list[tuple[Room | Patch, float]] = [*((r, 0.0) for r in scene.rooms), *((p, 0.002) for p in scene.patches)]
    parts = [(_middle(f.min, f.max), *_size(f.min, f.max), -FLOOR_THICKNESS, level) for f, level in levels]
    return boxes(parts, [d.floor_color(f.floor) for f, _ in levels])


def _wall(a: tuple[float, float], b: tuple[float, float], thickness: float, height: float) -> Box:
    heading = math.atan2(b[1] - a[1], b[0] - a[0])
    middle = Pose2D((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, heading)
    return middle, math.dist(a, b), thickness, 0.0, height


def _middle(low: tuple[float, float], high: tuple[float, float]) -> Pose2D:
    return Pose2D((low[0] + high[0]) / 2, (low[1] + high[1]) / 2)


def _size(low: tuple[float, float], high: tuple[float, float]) -> tuple[float, float]:
    return high[0] - low[0], high[1] - low[1]
