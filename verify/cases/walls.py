"""A robot next to a wall, or at the end of a slot, all else free: it gets away and reaches a goal."""

import asyncio
import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from threewe import Pose2D, Robot, RobotProfile

ROOM = """\
name: {name}
description: a room and the wall that the robot stands beside
starts: [[0.0, 0.0, 0.0]]
rooms:
  - {{name: room, min: [-3, -3], max: [3, 3], floor: tile, anchor: [0.0, 0.0]}}
walls:
  - {{a: [-3, -3], b: [3, -3], thickness: 0.1}}
  - {{a: [3, -3], b: [3, 3], thickness: 0.1}}
  - {{a: [3, 3], b: [-3, 3], thickness: 0.1}}
  - {{a: [-3, 3], b: [-3, -3], thickness: 0.1}}
"""
SLOT = """\
  - {{a: [{right:.4f}, -3], b: [{right:.4f}, {mouth:.4f}], thickness: 0.1}}
  - {{a: [{left:.4f}, -3], b: [{left:.4f}, {mouth:.4f}], thickness: 0.1}}
"""
SURFACE = -2.95  # [m] of the wall to the south


def away_from_a_wall(seed: int, hardware: str) -> dict[str, Any]:
    """Beside a wall, 1 mm to 10 cm free, half of the time along it, else with any heading; the goal is anywhere."""
    rng = np.random.default_rng(seed)
    heading = rng.choice([0.0, math.pi]) if rng.random() < 0.5 else rng.uniform(-math.pi, math.pi)
    free = rng.uniform(0.001, 0.1)
    start = Pose2D(rng.uniform(-1.5, 1.5), SURFACE + free + depth(hardware, heading), heading)
    goal = rng.uniform(-2.0, 2.0), rng.uniform(-2.0, 2.0)
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / f"room_{seed}.yaml"
        scene.write_text(ROOM.format(name=scene.stem))
        return {"free": free, **asyncio.run(drive(seed, str(scene), hardware, start, goal))}


def out_of_a_slot(seed: int, hardware: str) -> dict[str, Any]:
    """At the end of a slot, 12 to 24 cm wider than the robot and up to 1.2 m deep, nose first; the goal is anywhere."""
    rng = np.random.default_rng(seed)
    half = depth(hardware, 0.0) + rng.uniform(0.06, 0.12)
    start = Pose2D(rng.uniform(-0.02, 0.02), SURFACE + depth(hardware, -0.5 * math.pi) + 0.08, -0.5 * math.pi)
    slot = SLOT.format(left=-half - 0.05, right=half + 0.05, mouth=SURFACE + rng.uniform(0.5, 1.2))
    goal = rng.uniform(-2.0, 2.0), rng.uniform(-1.0, 2.0)
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / f"slot_{seed}.yaml"
        scene.write_text(ROOM.format(name=scene.stem) + slot)
        return {"half": half, **asyncio.run(drive(seed, str(scene), hardware, start, goal))}


def comes_to_its_goal(case: dict[str, Any]) -> bool:
    """In truth, also where it is too uncertain of its pose to say so: in a slot it sees little to know it by."""
    return bool(case["true_distance"] <= 0.25)


def touches_gently(case: dict[str, Any]) -> bool:
    """At the speed of creeping at most."""
    return bool(case["contact_speed"] <= 0.05)


def depth(hardware: str, heading: float) -> float:
    """How far south of the base the robot's outline reaches [m]."""
    s, c = math.sin(heading), math.cos(heading)
    return max(-(s * x + c * y) for x, y in RobotProfile.load(hardware).footprint)


async def drive(seed: int, scene: str, hardware: str, start: Pose2D, goal: tuple[float, float]) -> dict[str, Any]:
    async with Robot(scene=scene, hardware=hardware, seed=seed, start_pose=start) as robot:
        truth = robot.simulation
        assert truth is not None
        to = start.inverse() * Pose2D(*goal, 0.0)
        result = await robot.move_to(to.x, to.y, timeout=180.0)
        pose = truth.true_pose()
        return {
            "reason": result.reason.name,
            "detail": result.detail,
            "seconds": result.duration,
            "true_distance": math.hypot(pose.x - goal[0], pose.y - goal[1]),
            "moved": math.hypot(pose.x - start.x, pose.y - start.y),
            "contact_speed": truth.max_collision_speed(),
        }
