"""ir-sim: a disc on two wheels, moved by its kinematics alone, among rectangles and circles."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("MPLBACKEND", "Agg")
import irsim
import numpy as np
from world import BEAMS, FORWARD, PERIOD, TURN, World, given, report_drives, report_scans

PLACES = 8  # it takes long
NAME = f"ir-sim {irsim.__version__}"


def main() -> None:
    """All that it is compared in."""
    world = given()
    for beams in (0, *BEAMS):
        env = load(world, beams)
        if beams:
            time_scans(world, env, beams)
        time_drives(world, env, beams)


def load(world: World, beams: int) -> irsim.EnvBase:
    """The office at the height of the lidar. Its world begins at (0, 0), so that all is moved there."""
    lidar = f"""
    sensors:
      - {{type: lidar2d, range_min: 0, range_max: {world.lidar_range}, angle_range: 6.283185307, number: {beams}}}"""
    text = f"""
world: {{height: 60, width: 60, offset: [-30, -30], step_time: {PERIOD}, sample_time: {PERIOD}, collision_mode: stop}}
robot:
  - kinematics: {{name: diff}}
    shape: {{name: circle, radius: 0.13}}
    state: [0, 0, 0]
    goal: [29, 29, 0]
    vel_max: [1, 2]
    vel_min: [-1, -2]{lidar if beams else ""}
obstacle:
"""
    for s in world.cut():
        shape = (
            f"{{name: circle, radius: {s.radius}}}"
            if s.radius
            else f"{{name: rectangle, length: {s.length}, width: {s.width}}}"
        )
        text += f"  - {{shape: {shape}, state: [{s.x}, {s.y}, {s.theta}]}}\n"
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "office.yaml"
        file.write_text(text)
        return irsim.make(str(file), headless=True, log_level="ERROR")


def time_scans(world: World, env: irsim.EnvBase, beams: int) -> None:
    """Its lidar alone."""
    lidar = env.robot.sensors[0]

    def scan(x: float, y: float, theta: float) -> Sequence[float]:
        lidar.step(np.array([[x], [y], [theta]]))
        return lidar.range_data

    row = {"who": f"{NAME}, lidar2d", "differs": f"exact, among {len(world.cut())} outlines in 2D"}
    report_scans(row, world, beams, scan, PLACES)


def time_drives(world: World, env: irsim.EnvBase, beams: int) -> None:
    """A step of its world, with the scan that it takes."""
    command = np.array([[FORWARD], [TURN]])

    def begin(x: float, y: float, theta: float) -> None:
        env.robot.set_state([x, y, theta])

    def step() -> Sequence[float]:
        env.step(command)
        return env.get_lidar_scan()["ranges"] if beams else []

    row = {
        "who": f"{NAME}, diff",
        "differs": "kinematics alone, one step of 0.1 s; a robot that touches something stays",
        "substeps": 1,
    }
    report_drives(row, world, beams, begin, step, PLACES)


if __name__ == "__main__":
    main()
