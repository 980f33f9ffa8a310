"""What the areas that drive have in common: one sampled episode, driven and judged by the truth."""

import asyncio
import itertools
import math
import random
from typing import Any

from threewe import CoverageMeter, OccupancyGrid, Pose2D, Robot, RobotProfile, Scene, SceneTables, TickView, World
from threewe.benchmark import nearest_frontier, optimistic_replanning, spl

TOLERANCE = 0.1  # [m] of drives in vain


def drive(seed: int, scene: str, hardware: str, backend: str = "mock") -> dict[str, Any]:
    """From a sampled start to a sampled goal, in a place that the robot has never seen."""
    profile = RobotProfile.load(hardware)
    tables = SceneTables(Scene.load(scene), profile)
    episode = tables.sample_episode(seed, 0)
    best = optimistic_replanning(tables, profile, episode.start, episode.goal) if profile.lidar else None
    goal = episode.start.inverse() * Pose2D(*episode.goal, 0.0)

    async def run() -> dict[str, Any]:
        async with Robot(backend, hardware, scene, seed=seed, start_pose=episode.start) as robot:
            truth = robot.simulation
            assert truth is not None
            result = await robot.move_to(goal.x, goal.y)
            await robot.sleep(0.5)
            pose = truth.true_pose()
            believed = episode.start * robot.get_pose()
            true_distance = math.hypot(pose.x - episode.goal[0], pose.y - episode.goal[1])
            success = result.reason.name == "reached" and true_distance <= 0.25
            return {
                "reason": result.reason.name,
                "detail": result.detail,
                "seconds": result.duration,
                "geodesic": episode.geodesic,
                "driven": truth.distance_driven(),
                "spl": spl(success, episode.geodesic, truth.distance_driven()),
                "optimist_spl": spl(best.reached, episode.geodesic, best.length) if best else None,
                "optimist_seconds": best.duration if best else None,
                "true_distance": true_distance,
                "localisation_error": math.hypot(pose.x - believed.x, pose.y - believed.y),
                "contact_speed": truth.max_collision_speed(),
            }

    return asyncio.run(run())


def drives_in_a_map(seed: int, scene: str, drives: int) -> dict[str, Any]:
    """From sampled starts to sampled goals, in a map that a robot drew by exploring; it is told where it starts."""
    tables = SceneTables(Scene.load(scene), RobotProfile.load("3we_standard_v2"))

    async def draw() -> OccupancyGrid:
        async with Robot(scene=scene, seed=seed) as robot:
            await robot.explore()
            return robot.get_map()

    async def follow(grid: OccupancyGrid, drive: int) -> dict[str, Any]:
        episode = tables.sample_episode(seed, drive)
        # the map was begun at the scene's own start pose, so that its frame is the scene's
        async with Robot(
            scene=scene, map=grid, seed=seed + 1 + drive, start_pose=episode.start, initial_pose=episode.start
        ) as robot:
            truth = robot.simulation
            assert truth is not None
            result = await robot.move_to(*episode.goal)
            await robot.sleep(0.5)
            pose = truth.true_pose()
            true_distance = math.hypot(pose.x - episode.goal[0], pose.y - episode.goal[1])
            success = result.reason.name == "reached" and true_distance <= 0.25
            return {
                "reason": result.reason.name,
                "true_distance": true_distance,
                "spl": spl(success, episode.geodesic, truth.distance_driven()),
                "contact_speed": truth.max_collision_speed(),
            }

    grid = asyncio.run(draw())
    return {"drives": [asyncio.run(follow(grid, drive)) for drive in range(drives)]}


def spl_of(case: dict[str, Any]) -> float:
    """Success weighted by path length."""
    return float(case["spl"])


def contact(case: dict[str, Any]) -> float:
    """[m/s] The fastest contact by the robot's own motion."""
    return float(case["contact_speed"])


def arrived(case: dict[str, Any]) -> bool:
    """The robot says so, and it is true."""
    return bool(case["reason"] == "reached" and case["true_distance"] <= 0.25)


def tells_the_truth(case: dict[str, Any]) -> bool:
    """It says that it is there only where it is."""
    return bool(case["reason"] != "reached" or case["true_distance"] <= TOLERANCE)


def truly_there(case: dict[str, Any]) -> bool:
    """It says that it is there only where it is, within 0.25 m."""
    return bool(case["reason"] != "reached" or case["true_distance"] <= 0.25)


def drive_in_vain(seed: int, scene: str, hardware: str) -> dict[str, Any]:
    """To a place that nobody can reach: in a wall, under furniture, outside. Time enough to look everywhere."""
    place = Scene.load(scene)
    tables = SceneTables(place, RobotProfile.load(hardware))
    start = tables.sample_episode(seed, 0).start
    there = unreachable_place(tables, place, start, seed)
    goal = start.inverse() * Pose2D(*there, 0.0)

    async def run() -> dict[str, Any]:
        async with Robot(scene=scene, hardware=hardware, seed=seed, start_pose=start) as robot:
            truth = robot.simulation
            assert truth is not None
            result = await robot.move_to(goal.x, goal.y, tolerance=TOLERANCE, timeout=1800.0)
            pose = truth.true_pose()
            return {
                "reason": result.reason.name,
                "true_distance": math.hypot(pose.x - there[0], pose.y - there[1]),
                "detail": result.detail,
                "seconds": result.duration,
                "driven": truth.distance_driven(),
                "contact_speed": truth.max_collision_speed(),
            }

    return asyncio.run(run())


def unreachable_place(tables: SceneTables, scene: Scene, start: Pose2D, seed: int) -> tuple[float, float]:
    """Uniform over the scene and 5 m around it, given that no place within the tolerance can be reached."""
    draw = random.Random(seed)
    steps = [-0.1, -0.05, 0.0, 0.05, 0.1]
    while True:
        x = draw.uniform(scene.min[0] - 5.0, scene.max[0] + 5.0)
        y = draw.uniform(scene.min[1] - 5.0, scene.max[1] + 5.0)
        around = [(x + dx, y + dy) for dx in steps for dy in steps if math.hypot(dx, dy) < TOLERANCE + 0.05]
        if not any(math.isfinite(tables.geodesic((start.x, start.y), place)) for place in around):
            return x, y


def explore(seed: int, scene: str, times: float | None = 1.5) -> dict[str, Any]:
    """Explores from a sampled start, for so many times as long as nearest-frontier takes with a perfect pose, or until
    it is done.
    """
    profile = RobotProfile.load("3we_standard_v2")
    tables = SceneTables(Scene.load(scene), profile)
    start = tables.sample_free_pose(seed)
    reference = nearest_frontier(tables, profile, start)
    case = explore_from(start, seed, scene, times * reference.duration if times else None)
    return case | {"reference_seconds": reference.duration, "reference_coverage": reference.coverage}


def explore_from(
    start: Pose2D, seed: int, scene: str, timeout: float | None = None, hardware: str = "3we_standard_v2"
) -> dict[str, Any]:
    """An exploration, and how much of the scene it truly saw."""

    async def run() -> dict[str, Any]:
        async with Robot(scene=scene, hardware=hardware, seed=seed, start_pose=start) as robot:
            truth = robot.simulation
            assert truth is not None
            meter = CoverageMeter(truth)

            def look(tick: TickView) -> None:
                if round(tick.now / 0.02) % 10 == 0:
                    meter.observe(truth.true_pose())

            robot.observe(look)
            result = await robot.explore(timeout=timeout)
            return {
                "reason": result.reason.name,
                "detail": result.detail,
                "seconds": result.duration,
                "coverage": meter.coverage(robot.get_map()),
                "driven": truth.distance_driven(),
                "contact_speed": truth.max_collision_speed(),
            }

    return asyncio.run(run())


def explore_together(seed: int, scene: str, strangers: bool) -> dict[str, Any]:
    """Two robots explore at once, from starts near one another; strangers know of one another what they see."""
    profile = RobotProfile.load("3we_standard_v2")
    tables = SceneTables(Scene.load(scene), profile)
    first = tables.sample_free_pose(seed)
    candidates = (tables.sample_free_pose(seed + 1000 * k) for k in itertools.count(1))
    starts = [first, next(pose for pose in candidates if 0.6 < math.hypot(pose.x - first.x, pose.y - first.y) < 3.0)]

    async def run() -> dict[str, Any]:
        initial = [] if strangers else starts
        async with World(scene=scene, seed=seed, start_poses=starts, initial_poses=initial) as world:
            truths = [robot.simulation for robot in world.robots]
            await asyncio.gather(*(robot.explore(timeout=400.0) for robot in world.robots))
            return {
                "contact_speed": max(truth.max_collision_speed() for truth in truths if truth),
                "driven": sum(truth.distance_driven() for truth in truths if truth),
            }

    return asyncio.run(run())
