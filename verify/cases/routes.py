"""Instructions through rooms whose borders are known, in scenes that the robot and its detector have never seen."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache

from threewe import Pose2D, RobotProfile, Scene, sync
from threewe._core import SceneTables, Vln

from verify.cases.generated import building, saved
from verify.harness import Case

TIMEOUT = 600.0  # [s] of robot time


@contextmanager
def scene_of(name: str, seed: int) -> Iterator[str]:
    """A scene by its name, or the file of a building that the seed draws."""
    if name != "generated":
        yield name
        return
    with saved(building(seed)) as path:
        yield path


@lru_cache(maxsize=4)
def _task(scene: str) -> Vln:
    return Vln(SceneTables(Scene.load(scene), RobotProfile.load("3we_standard_v2")))


def rooms_of(scene: str, start: Pose2D) -> Iterator[tuple[str, list[tuple[float, float]]]]:
    """The names and corners of a scene's rooms, in the map of a robot that starts at a pose."""
    map_from_scene = start.inverse()
    for name, room in zip(_task(scene).rooms, Scene.load(scene).rooms, strict=True):
        (x0, y0), (x1, y1) = room.min, room.max
        corners = [map_from_scene * Pose2D(x, y, 0.0) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
        yield name, [(corner.x, corner.y) for corner in corners]


def room_at(scene: str, x: float, y: float) -> str:
    """The name of the room that holds a point; empty where none does."""
    rooms = Scene.load(scene).rooms
    inside = (r.name for r in rooms if r.min[0] <= x <= r.max[0] and r.min[1] <= y <= r.max[1])
    return next(inside, "")


def follow(seed: int, place: str, shuffled: bool = False) -> Case:
    """An episode of 3we/VLN-v1: its text, or that of another one of the scene, and the borders of rooms are given."""
    with scene_of(place, seed) as scene:
        task = _task(scene)
        episode = task.sample(seed)
        text, index = episode.instruction, 0
        while shuffled and text == episode.instruction:
            index += 1
            text = task.sample(seed, index).instruction
        with sync.Robot(scene=scene, seed=seed, start_pose=episode.start) as robot:
            for name, corners in rooms_of(scene, episode.start):
                robot.name_place(name, corners)
            result = robot.execute_instruction(text, timeout=TIMEOUT)
            assert robot.simulation is not None
            pose = robot.simulation.true_pose()
            return {
                "place": place,
                "text": text,
                "reason": result.reason,
                "detail": result.detail,
                "room": room_at(scene, pose.x, pose.y) == room_at(scene, *episode.end),
                "right": task.is_success(episode, (pose.x, pose.y)),
                "success": result.success and task.is_success(episode, (pose.x, pose.y)),
                "verified": result.verified,
                "collision_speed": robot.simulation.max_collision_speed(),
                "duration": result.duration,
            }
