"""Scenes and robots as files for other simulators and for ROS."""

from __future__ import annotations

import os
from pathlib import Path

from threewe._core import RobotProfile, Scene, export_files


def export(
    scene: str | Scene, robot: str | RobotProfile, format: str, folder: str | os.PathLike[str] = "."
) -> list[Path]:
    """Writes a scene, and a robot at its first start, for another simulator; returns the files.

    Formats: `mjcf` (MuJoCo), `urdf` (ROS 2), `sdf` (Gazebo Harmonic), `usd` (Isaac Sim), `map` (ROS). Scene and robot
    are names, files that end in .yaml, or objects. Raises ConfigError, with nothing written, where one is unknown.
    """
    if isinstance(scene, str):
        scene = Scene.load(scene)
    if isinstance(robot, str):
        robot = RobotProfile.load(robot)
    return export_files(scene, robot, format, os.fspath(folder))
