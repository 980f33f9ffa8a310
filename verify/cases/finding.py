"""Instructions that look for things, in scenes that the robot and its detector have never seen."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache

import numpy as np
from threewe import Robot, Scene, sync
from threewe._core import DriveLog, Object, ObjectNav, ObjectNavEpisode, SceneTables, color_names

from verify.cases.seeing import terms_of
from verify.harness import Case

SCENES = ("office_v2", "apartment_v1", "warehouse_v1", "cluttered_v1")
TIMEOUT = 600.0  # [s] of robot time
SIDES = 8  # from which a thing is looked at
AWAY = 1.5  # [m] from its middle
LEAST_PIXELS = 200  # of it, in a view
CLEAR = 0.6  # least share of all that is seen of a thing, of the color that it has


@cache
def _task(scene: str) -> ObjectNav:
    profile = Robot().profile
    return ObjectNav(SceneTables(Scene.load(scene), profile), profile)


def find(seed: int, scene: str, colored: bool = False) -> Case:
    """ "find the [COLOR] KIND": success by the rule of 3we/ObjectNav-v1, at a thing that truly has that color."""
    task = _task(scene)
    color, index = "", 0
    episode = _drawn(task, seed, index)
    with sync.Robot(scene=scene, seed=seed, start_pose=episode.start) as robot:
        colors = true_colors(robot) if colored else {}
        while colored and not color:
            kinds = {thing.name: thing.category for thing in robot.simulation.scene.objects}
            known = sorted({colors[name] for name, kind in kinds.items() if kind == episode.category and colors[name]})
            if known:
                color = known[seed % len(known)]
            else:
                index += 1
                episode = _drawn(task, seed, index)
        robot.simulation.reset(seed=seed, pose=episode.start)
        log = robot._thread.call(lambda: DriveLog(robot._target._world))
        result = robot.execute_instruction(f"find the {color} {episode.category}", timeout=TIMEOUT)
        things = robot._thread.call(lambda: task.found(robot.profile, episode.category, log))
        right = any(not colored or colors[name] == color for name in things)
        return {
            "scene": scene,
            "kind": episode.category,
            "color": color,
            "reason": result.reason,
            "found": bool(result.success and right),
            "claimed_wrong": bool(result.success and result.verified and not right),
            "another_color": bool(result.success and things and not right),
            "collision_speed": robot.simulation.max_collision_speed(),
            "duration": result.duration,
        }


def _drawn(task: ObjectNav, seed: int, index: int) -> ObjectNavEpisode:
    """The first episode from an index on that is no door and not at hand."""
    while (episode := task.sample(seed, index)).category == "door" or episode.geodesic < 2.0:
        index += 1
    return episode


def true_colors(robot: sync.Robot) -> Mapping[str, str]:
    """The color term that most of a thing truly has, without noise, by its name; empty where no term is clear."""
    return {thing.name: _true_color(robot, thing) for thing in robot.simulation.scene.objects}


def _true_color(robot: sync.Robot, thing: Object) -> str:
    counts = np.zeros(len(color_names()), np.int64)
    for side in range(SIDES):
        angle = 2 * math.pi * side / SIDES
        at = thing.pose.x - AWAY * math.cos(angle), thing.pose.y - AWAY * math.sin(angle)
        truth = robot.simulation.look(pose=(*at, angle), with_itself=False)
        shown = truth.ids == truth.names.index(thing.name)
        if np.count_nonzero(shown) >= LEAST_PIXELS:
            counts += np.bincount(terms_of(truth.color[shown]), minlength=len(counts))
    most = int(np.argmax(counts))
    return color_names()[most] if counts[most] > CLEAR * counts.sum() else ""
