"""Scenes and robots as files for other simulators and for ROS."""

from __future__ import annotations

import os
from pathlib import Path

from threewe._arguments import as_asset, as_file, as_switch, as_text
from threewe._core import RobotProfile, Scene, export_files, places_of_scene, save_places
from threewe.errors import ConfigError


def export(
    scene: str | os.PathLike[str] | Scene,
    robot: str | os.PathLike[str] | RobotProfile,
    format: str,
    folder: str | os.PathLike[str] = ".",
    *,
    places: bool = False,
) -> list[Path]:
    """Writes a scene, and a robot at its first start, for another simulator; returns the files.

    Formats: `mjcf` (MuJoCo), `urdf` (ROS 2), `sdf` (Gazebo Harmonic), `usd` (Isaac Sim), `map` (ROS). Scene and robot
    are names, files that end in .yaml, or objects. With `places`, the rooms of a `map` are written as `places.yaml`
    beside it, see `Robot.load_places`. Raises ConfigError, with nothing written, where one is unknown.
    """
    if as_switch("places", places) and format != "map":
        raise ConfigError(f"places are written with the format 'map', not with '{format}'")
    place = scene if isinstance(scene, Scene) else Scene.load(as_asset("scene", scene))
    profile = robot if isinstance(robot, RobotProfile) else RobotProfile.load(as_asset("robot", robot))
    files = export_files(place, profile, as_text("format", format), str(as_file("folder", folder)))
    if places:
        files.append(as_file("folder", folder) / "places.yaml")
        save_places(places_of_scene(place), str(files[-1]))
    return files
