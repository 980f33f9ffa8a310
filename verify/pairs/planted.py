"""Changes of one parameter, or of one sign, of a robot: each is to be caught by drives that it changes."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from threewe import RobotProfile

from verify.cases.trees import ROOT

ASSETS = ROOT / "assets"
STANDARD, TURTLEBOT, BASE = "3we_standard_v2", "turtlebot_like", "3we_base_v2"
DOOR, WALL, MAZE = "doorway/{}/100_mm/0", "wall/{}/0", "maze/{}/0"


@dataclass(frozen=True)
class Change:
    """One figure of a profile, by its path in the YAML, times a factor; -1 is a sign. `drive` is changed by it."""

    hardware: str
    path: str
    factor: float
    drive: str

    def __str__(self) -> str:
        """Names the change, for a test."""
        return f"{self.hardware}: {self.path} x {self.factor:g}"


def parameter(name: str, factor: float, drive: str, hardware: str = STANDARD) -> Change:
    """Returns a change of one parameter of the autonomy stack."""
    return Change(hardware, f"autonomy.{name}", factor, drive.format(hardware))


def sign(path: str, drive: str, hardware: str = STANDARD) -> Change:
    """Returns a change of one sign."""
    return Change(hardware, path, -1.0, drive.format(hardware))


PLANTED = [
    parameter("nav.follower.position_gain", 1.01, WALL),
    parameter("nav.follower.heading_gain", 1.01, DOOR),
    parameter("nav.clearance.caution", 1.05, MAZE),
    parameter("nav.creep.speed", 1.05, DOOR),
    parameter("nav.narrow_passage.measuring", 1.2, DOOR),
    parameter("nav.mppi.temperature", 1.01, WALL),
    parameter("nav.mppi.weights.obstacle_braking", 1.01, DOOR, TURTLEBOT),
    parameter("nav.route.unknown_weight", 1.5, MAZE),
    parameter("nav.frontier.strip", 1.5, "exploration/apartment_v1/0"),
    parameter("slam.filter.lateral_slip", 1.05, WALL),
    parameter("slam.matching.residual", 1.01, WALL),
    parameter("slam.mapping.distance", 1.1, DOOR),
    parameter("slam.global_search.good_score", 1.2, "anywhere/apartment_v1"),
    parameter("safety.gate.margin", 1.1, DOOR),
    sign("sensors.lidar.base_from_lidar.0", WALL),
    sign("sensors.lidar.base_from_lidar.0", WALL, TURTLEBOT),
    sign("sensors.lidar.clockwise", WALL),
    sign("sensors.camera.base_from_camera.0", "navigation/office_v2/none"),
    sign("sensors.ultrasonics.mounts.left.2", "sonar/{}/0", BASE),
    sign("sensors.ultrasonics.mounts.front_left.1", "sonar/{}/0", BASE),
]


@contextmanager
def planted(change: Change) -> Iterator[None]:
    """Gives processes that begin meanwhile the assets with one change."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "robots").mkdir()
        for part in [*ASSETS.iterdir(), *(ASSETS / "robots").iterdir()]:
            link = folder / part.relative_to(ASSETS)
            if not link.exists():
                link.symlink_to(part)
        path = folder / "robots" / f"{change.hardware}.yaml"
        profile = yaml.safe_load(path.read_text())
        if "extends" in profile and not change.path.startswith("autonomy."):
            raise ValueError(f"{path.name} has its sensors of another profile")
        path.unlink()
        change_value(profile, change)
        path.write_text(yaml.safe_dump(profile))
        before = os.environ.get("THREEWE_ASSETS")
        os.environ["THREEWE_ASSETS"] = name
        try:
            yield
        finally:
            os.environ.pop("THREEWE_ASSETS")
            if before is not None:
                os.environ["THREEWE_ASSETS"] = before


def change_value(profile: dict[str, Any], change: Change) -> None:
    """Changes one figure of a profile that was read; a parameter that is not in it begins from its default."""
    *way, last = change.path.split(".")
    node: Any = profile
    for key in way:
        node = node[int(key)] if isinstance(node, list) else node.setdefault(key, {})
    key = int(last) if isinstance(node, list) else last
    if change.path.startswith("autonomy."):
        parameters = {one.name: one.value for one in RobotProfile.load(change.hardware).parameters()}
        value = parameters[change.path.removeprefix("autonomy.")]
    else:
        value = node[key]
    node[key] = not value if isinstance(value, bool) else change.factor * value
