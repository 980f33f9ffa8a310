"""Instructions that look for things, in scenes that the robot and its detector have never seen."""

from __future__ import annotations

from functools import cache

from threewe import Robot, Scene, sync
from threewe._core import DriveLog, ObjectNav, SceneTables

from verify.harness import Case

SCENES = ("office_v2", "apartment_v1", "warehouse_v1", "cluttered_v1")
TIMEOUT = 600.0  # [s] of robot time


@cache
def _task(scene: str) -> ObjectNav:
    profile = Robot().profile
    return ObjectNav(SceneTables(Scene.load(scene), profile), profile)


def find(seed: int, scene: str) -> Case:
    """ "find the KIND": success by the rule of 3we/ObjectNav-v1 where the robot has come to, and what it claims."""
    task = _task(scene)
    index = 0
    episode = task.sample(seed, index)
    while episode.category == "door" or episode.geodesic < 2.0:
        index += 1
        episode = task.sample(seed, index)
    with sync.Robot(scene=scene, seed=seed, start_pose=episode.start) as robot:
        log = robot._thread.call(lambda: DriveLog(robot._target._world))
        result = robot.execute_instruction(f"find the {episode.category}", timeout=TIMEOUT)
        right = robot._thread.call(lambda: task.is_success(robot.profile, episode.category, log))
        return {
            "scene": scene,
            "kind": episode.category,
            "reason": result.reason,
            "found": bool(result.success and right),
            "claimed_wrong": bool(result.success and not right),
            "collision_speed": robot.simulation.max_collision_speed(),
            "duration": result.duration,
        }
