"""What the areas that drive have in common: one sampled episode, driven and judged by the truth."""

import asyncio
import math
from typing import Any

from threewe import CoverageMeter, Pose2D, Robot, RobotProfile, Scene, SceneTables, TickView


def drive(seed: int, scene: str, hardware: str) -> dict[str, Any]:
    """From a sampled start to a sampled goal, in a place that the robot has never seen."""
    tables = SceneTables(Scene.load(scene), RobotProfile.load(hardware))
    episode = tables.sample_episode(seed, 0)
    goal = episode.start.inverse() * Pose2D(*episode.goal, 0.0)

    async def run() -> dict[str, Any]:
        async with Robot(scene=scene, hardware=hardware, seed=seed, start_pose=episode.start) as robot:
            truth = robot.simulation
            assert truth is not None
            result = await robot.move_to(goal.x, goal.y)
            await robot.sleep(0.5)
            pose = truth.true_pose()
            believed = episode.start * robot.get_pose()
            return {
                "reason": result.reason.name,
                "detail": result.detail,
                "seconds": result.duration,
                "geodesic": episode.geodesic,
                "driven": truth.distance_driven(),
                "true_distance": math.hypot(pose.x - episode.goal[0], pose.y - episode.goal[1]),
                "localisation_error": math.hypot(pose.x - believed.x, pose.y - believed.y),
                "contact_speed": truth.max_collision_speed(),
            }

    return asyncio.run(run())


def arrived(case: dict[str, Any]) -> bool:
    """The robot says so, and it is true."""
    return bool(case["reason"] == "reached" and case["true_distance"] <= 0.25)


def explore(seed: int, scene: str, seconds: float) -> dict[str, Any]:
    """Explores from the scene's start, for so many robot seconds."""

    async def run() -> dict[str, Any]:
        async with Robot(scene=scene, seed=seed) as robot:
            truth = robot.simulation
            assert truth is not None
            meter = CoverageMeter(truth)

            def look(tick: TickView) -> None:
                if round(tick.now / 0.02) % 10 == 0:
                    meter.observe(truth.true_pose())

            robot.observe(look)
            result = await robot.explore(timeout=seconds)
            return {
                "reason": result.reason.name,
                "seconds": result.duration,
                "coverage": meter.coverage(robot.get_map()),
                "driven": truth.distance_driven(),
                "contact_speed": truth.max_collision_speed(),
            }

    return asyncio.run(run())
