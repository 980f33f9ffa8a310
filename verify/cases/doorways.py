"""Two rooms and a doorway between them, the only way: hardly wider than the robot, or too narrow for it."""

import asyncio
import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from threewe import Pose2D, Robot, RobotProfile

TWO_ROOMS = """\
name: {name}
description: two rooms and a doorway
starts: [[0.0, 0.0, 0.0]]
rooms:
  - {{name: west, min: [-2, -2], max: [2, 2], floor: tile, anchor: [0.0, 0.0]}}
  - {{name: east, min: [2, -2], max: [6, 2], floor: tile, anchor: [4.0, 0.0]}}
walls:
  - {{a: [-2, -2], b: [6, -2], thickness: 0.15}}
  - {{a: [6, -2], b: [6, 2], thickness: 0.15}}
  - {{a: [6, 2], b: [-2, 2], thickness: 0.15}}
  - {{a: [-2, 2], b: [-2, -2], thickness: 0.15}}
  - {{a: [{south[0]:.4f}, {south[1]:.4f}], b: [{right[0]:.4f}, {right[1]:.4f}], thickness: {thickness:.3f}}}
  - {{a: [{left[0]:.4f}, {left[1]:.4f}], b: [{north[0]:.4f}, {north[1]:.4f}], thickness: {thickness:.3f}}}
"""


def through_a_doorway(seed: int, hardware: str, spare: float) -> dict[str, Any]:
    """From anywhere in one room to anywhere in the other; the doorway is wider than the robot by `spare` [m]."""
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / f"two_rooms_{seed}.yaml"
        scene.write_text(two_rooms(scene.stem, width(hardware) + spare, rng))
        start = Pose2D(rng.uniform(-1.4, 0.6), rng.uniform(-1.4, 1.4), rng.uniform(-math.pi, math.pi))
        goal = rng.uniform(3.4, 5.4), rng.uniform(-1.4, 1.4)
        return asyncio.run(drive(seed, str(scene), hardware, start, goal))


def two_rooms(name: str, gap: float, rng: np.random.Generator) -> str:
    """A wall between two rooms, somewhat askew, and a gap [m] in it."""
    middle, askew = np.array([2.0, rng.uniform(-0.8, 0.8)]), rng.uniform(-0.2, 0.2)
    along = np.array([math.sin(askew), math.cos(askew)])
    south, north = (middle + along * (y - middle[1]) / along[1] for y in (-2.0, 2.0))
    left, right = middle + 0.5 * gap * along, middle - 0.5 * gap * along
    sides = {"south": south, "north": north, "left": left, "right": right}
    return TWO_ROOMS.format(name=name, thickness=rng.uniform(0.06, 0.25), **sides)


def width(hardware: str) -> float:
    """Of the robot [m], across the direction in which it drives."""
    across = [corner[1] for corner in RobotProfile.load(hardware).footprint]
    return max(across) - min(across)


async def drive(seed: int, scene: str, hardware: str, start: Pose2D, goal: tuple[float, float]) -> dict[str, Any]:
    async with Robot(scene=scene, hardware=hardware, seed=seed, start_pose=start) as robot:
        truth = robot.simulation
        assert truth is not None
        to = start.inverse() * Pose2D(*goal, 0.0)
        result = await robot.move_to(to.x, to.y)
        pose = truth.true_pose()
        return {
            "reason": result.reason.name,
            "seconds": result.duration,
            "true_distance": math.hypot(pose.x - goal[0], pose.y - goal[1]),
            "contact_speed": truth.max_collision_speed(),
        }
