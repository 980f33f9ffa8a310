"""Drives to far goals in places that nobody has tuned to: generated buildings, empty halls, bare corridors."""

import asyncio
import math
import random
import statistics
import tempfile
from pathlib import Path
from typing import Any

from threewe import Pose2D, Robot, RobotProfile, Scene, SceneTables
from threewe.benchmark import spl

SIDES = ((14.0, 32.0), (10.0, 20.0))  # [m] of buildings, drawn from these
FAR = 0.4  # of a place's diagonal: goals are at least so far away, along the shortest path

BARE = """\
name: {name}
description: four walls
starts: [[0.0, 0.0, 0.0]]
rooms:
  - {{name: hall, min: [-{x}, -{y}], max: [{x}, {y}], floor: tile, anchor: [0.0, 0.0]}}
walls:
  - {{a: [-{x}, -{y}], b: [{x}, -{y}], thickness: 0.15}}
  - {{a: [{x}, -{y}], b: [{x}, {y}], thickness: 0.15}}
  - {{a: [{x}, {y}], b: [-{x}, {y}], thickness: 0.15}}
  - {{a: [-{x}, {y}], b: [-{x}, -{y}], thickness: 0.15}}
"""


def building(seed: int) -> str:
    """A furnished building, as text; its size and how crowded it is are drawn too."""
    draw = random.Random(seed)
    size = draw.uniform(*SIDES[0]), draw.uniform(*SIDES[1])
    return Scene.generate(seed, difficulty=draw.random(), size=size).to_yaml(f"building_{seed}")


def hall(seed: int) -> str:
    """A hall in which most lidars see nothing from the middle."""
    side = random.Random(seed).uniform(20.0, 40.0)
    return BARE.format(name=f"hall_{seed}", x=0.5 * side, y=0.5 * side)


def corridor(seed: int) -> str:
    """A corridor along which most lidars see nothing but its walls."""
    draw = random.Random(seed)
    return BARE.format(name=f"corridor_{seed}", x=0.5 * draw.uniform(30.0, 60.0), y=0.5 * draw.uniform(1.6, 3.0))


PLACES = {"building": building, "hall": hall, "corridor": corridor}


def far_drives(seed: int, place: str, hardware: str, drives: int) -> dict[str, Any]:
    """Drives in one place, each from a start and to a goal of its own, in an unknown map and without a time limit."""
    profile = RobotProfile.load(hardware)
    with tempfile.TemporaryDirectory() as folder:
        text = PLACES[place](seed)
        path = Path(folder) / f"{place}_{seed}.yaml"
        path.write_text(text)
        scene = Scene.load(str(path))
        tables = SceneTables(scene, profile)
        tasks = [far_goal(scene, tables, seed + drive) for drive in range(drives)]
        outcomes = [asyncio.run(drive_far(str(path), hardware, seed + k, *task)) for k, task in enumerate(tasks)]
    return {"drives": outcomes}


async def drive_far(
    scene: str, hardware: str, seed: int, start: Pose2D, goal: tuple[float, float], geodesic: float
) -> dict[str, Any]:
    to = start.inverse() * Pose2D(*goal, 0.0)
    async with Robot(scene=scene, hardware=hardware, seed=seed, start_pose=start) as robot:
        truth = robot.simulation
        assert truth is not None
        result = await robot.move_to(to.x, to.y)
        pose = truth.true_pose()
        velocity = robot.get_velocity()
        distance = math.hypot(pose.x - goal[0], pose.y - goal[1])
        reached = result.reason.name == "reached"
        return {
            "reason": result.reason.name,
            "detail": result.detail,
            "seconds": result.duration,
            "true_distance": distance,
            "distance": result.distance_to_goal,
            "uncertainty": result.position_uncertainty,
            "speed": math.hypot(velocity.vx, velocity.vy),
            "spl": spl(reached and distance <= 0.25, geodesic, truth.distance_driven()),
            "contact_speed": truth.max_collision_speed(),
        }


def far_goal(scene: Scene, tables: SceneTables, seed: int) -> tuple[Pose2D, tuple[float, float], float]:
    """A start, a goal, and the length [m] of the shortest path between them."""
    draw = random.Random(seed)
    low, high = scene.min, scene.max
    least = FAR * math.hypot(high[0] - low[0], high[1] - low[1])
    while True:
        start, goal = (tables.sample_free_pose(draw.randrange(2**31)) for _ in range(2))
        geodesic = tables.geodesic((start.x, start.y), (goal.x, goal.y))
        if math.isfinite(geodesic) and geodesic >= least:
            return start, (goal.x, goal.y), geodesic


def arrivals(case: dict[str, Any]) -> list[float]:
    """1 for each drive of a place that ends truly at its goal, and says so, else 0."""
    return [float(d["reason"] == "reached" and d["true_distance"] <= 0.25) for d in case["drives"]]


def arrived_share(cases: list[dict[str, Any]]) -> str:
    """Of all drives, where nothing is asked: no robot can know its position in the middle of a hall."""
    every = [value for case in cases for value in arrivals(case)]
    return f"{statistics.fmean(every):.1%} of {len(every)}"


def no_clock(case: dict[str, Any]) -> bool:
    """No drive of a place ends by a time limit."""
    return all(d["reason"] != "timeout" for d in case["drives"])


def no_false_arrival(case: dict[str, Any]) -> bool:
    """No drive of a place says `reached` beyond the tolerance."""
    return all(d["reason"] != "reached" or d["true_distance"] <= 0.25 for d in case["drives"])


def ends_standing(case: dict[str, Any]) -> bool:
    """Every drive that says `reached` stands there."""
    return all(d["reason"] != "reached" or d["speed"] < 0.02 for d in case["drives"])


def worst_contact(case: dict[str, Any]) -> float:
    """[m/s] of all drives of a place."""
    return max(d["contact_speed"] for d in case["drives"])
