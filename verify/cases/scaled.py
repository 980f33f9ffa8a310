"""The same robot in another size: profile, building and furniture are scaled alike; times, and results, should stay."""

import asyncio
import math
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml
from threewe import Pose2D, Robot, RobotProfile, Scene, SceneTables
from threewe.benchmark import spl

from verify.cases.generated import building, far_goal, is_scene, saved
from verify.cases.trees import ROOT

ASSETS = ROOT / "assets"

# Of a body's figures, the power of the scale that each grows with where lengths, speeds and accelerations grow with the
# first power and densities stay: a force with the fourth, for it moves a mass that grows with the third. Friction and
# rolling resistance are forces over weights.
POWERS = {
    **dict.fromkeys(["length", "width", "height", "radius", "half_length", "half_width", "corners", "position"], 1),
    **dict.fromkeys(["linear", "linear_acceleration", "linear_braking", "friction", "rolling_resistance"], 1),
    **dict.fromkeys(["range_min", "range_max", "sigma", "bias", "accelerometer_sigma", "accelerometer_bias"], 1),
    "mass": 3,
    "stall_torque": 5,
    "inertia": 5,
    "capacity": 5,
    "idle_power": 5,
    "resistance": -5,
}
ON_TABLES = ("cup", "monitor")  # where no lidar looks, and too small to be scaled
SMALLEST, HIGHEST = 0.01, 10.0  # [m] that a thing may be
LENGTHS_IN_SCENES = {"min", "max", "anchor", "a", "b", "thickness", "height", "at", "width"}


def drive_in_sizes(seed: int, hardware: str, scales: list[float]) -> dict[str, Any]:
    """A far drive of a robot in a generated building, both in several sizes, with the original's start and goal."""
    text = building(seed)
    with saved(text) as path:
        tables = SceneTables(Scene.load(path), RobotProfile.load(hardware))
        start, goal, geodesic = far_goal(Scene.load(path), tables, seed)
    to = start.inverse() * Pose2D(*goal, 0.0)
    drives = []
    for scale in scales:
        with scaled_world(text, hardware, scale) as (scene, profile, origin):
            begin = Pose2D(scale * (start.x - origin[0]), scale * (start.y - origin[1]), start.theta)
            outcome = asyncio.run(drive(scene, profile, seed, scale, begin, to, geodesic))
            drives.append({"scale": scale, **outcome})
    return {"drives": drives}


async def drive(
    scene: str, hardware: str, seed: int, scale: float, start: Pose2D, to: Pose2D, geodesic: float
) -> dict[str, Any]:
    """Lengths of the outcome are in units of the scale, so that they compare with the original's."""
    async with Robot(scene=scene, hardware=hardware, seed=seed, start_pose=start) as robot:
        truth = robot.simulation
        assert truth is not None
        result = await robot.move_to(scale * to.x, scale * to.y, tolerance=0.25 * scale)
        pose = start.inverse() * truth.true_pose()
        distance = math.hypot(pose.x / scale - to.x, pose.y / scale - to.y)
        reached = result.reason.name == "reached" and distance <= 0.25
        return {
            "reason": result.reason.name,
            "detail": result.detail,
            "seconds": result.duration,
            "true_distance": distance,
            "uncertainty": result.position_uncertainty / scale,
            "spl": spl(reached, geodesic, truth.distance_driven() / scale),
            "contact_speed": truth.max_collision_speed() / scale,
        }


@contextmanager
def scaled_world(scene: str, hardware: str, scale: float) -> Iterator[tuple[str, str, list[float]]]:
    """Files of a scene and of a profile, and where in the original the scene's frame begins; meanwhile all furniture is
    scaled.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("objects", "robots", "scenes"):
            (folder / part).mkdir()
        for part in ASSETS.iterdir():
            if not (folder / part.name).exists():
                (folder / part.name).symlink_to(part)
        for file in (ASSETS / "objects").glob("*.yaml"):
            write(folder / "objects" / file.name, scaled_scene(yaml.safe_load(file.read_text()), scale))
        place = yaml.safe_load(scene)
        profile = yaml.safe_load((ASSETS / "robots" / f"{hardware}.yaml").read_text())
        write(folder / "robots" / f"{hardware}.yaml", scaled_profile(profile, scale))
        before = os.environ.get("THREEWE_ASSETS")
        os.environ["THREEWE_ASSETS"] = name
        try:
            file = folder / "scenes" / f"{place['name']}.yaml"
            origin = write_scene(file, place, scale)
            yield str(file), str(folder / "robots" / f"{hardware}.yaml"), origin
        finally:
            os.environ.pop("THREEWE_ASSETS")
            if before is not None:
                os.environ["THREEWE_ASSETS"] = before


def write_scene(path: Path, place: dict[str, Any], scale: float) -> list[float]:
    """Without rooms, which are names alone. Returns the start, with 0.25 m free around it, where the frame begins."""
    objects = [one for one in place["objects"] if one["category"] not in ON_TABLES]
    rooms = place.pop("rooms")
    for start in ([0.0, 0.0], *(room["anchor"] for room in rooms)):
        write(path, scaled_scene(place | {"objects": objects, "starts": [[*start, 0.0]]}, scale))
        if is_scene(path.read_text()):
            return start
    raise ValueError("no room has space for a start")


def write(path: Path, content: Any) -> None:
    path.write_text(yaml.safe_dump(content, sort_keys=False))


def scaled_profile(node: Any, scale: float, key: str = "") -> Any:
    """A profile's figures, each by its power; mounts by their places; without the camera, which no motion needs."""
    if isinstance(node, dict):
        if key == "mounts":
            return {name: scaled_place(pose, scale) for name, pose in node.items()}
        return {name: scaled_profile(value, scale, name) for name, value in node.items() if name != "camera"}
    if key.startswith("base_from_"):
        return scaled_place(node, scale)
    return multiplied(node, scale ** POWERS[key]) if key in POWERS else node


def scaled_scene(node: Any, scale: float, key: str = "") -> Any:
    """A scene's or an object's lengths; poses by their places."""
    if isinstance(node, dict):
        return {name: scaled_scene(value, scale, name) for name, value in node.items()}
    if key == "pose" or (key == "at" and isinstance(node, list)):
        return scaled_place(node, scale)
    if key == "starts" or (isinstance(node, list) and node and isinstance(node[0], dict)):
        return [scaled_place(one, scale) if key == "starts" else scaled_scene(one, scale) for one in node]
    if key == "z":
        high = min(scale * node[1], HIGHEST)
        return [max(min(scale * node[0], high - SMALLEST), 0.0), high]
    if key in ("box", "cylinder"):
        return [max(scale * side, SMALLEST) for side in node] if key == "box" else max(scale * node, SMALLEST)
    return multiplied(node, scale) if key in LENGTHS_IN_SCENES else node


def scaled_place(pose: list[float], scale: float) -> list[float]:
    """[x, y, theta], theta as it was."""
    return [scale * pose[0], scale * pose[1], *pose[2:]]


def multiplied(node: Any, factor: float) -> Any:
    """A number, or the numbers of nested lists."""
    return [multiplied(one, factor) for one in node] if isinstance(node, list) else node * factor
