"""Instructions to and through rooms whose borders are known, in scenes that the robot's detector has never seen."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

import threewe
from threewe import Pose2D, RobotProfile, Scene, sync
from threewe._core import Place, SceneTables, Vln, places_of_scene

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


def in_map(places: list[Place], start: Pose2D) -> Iterator[tuple[str, list[tuple[float, float]]]]:
    """Names and corners of places of a scene, in the map of a robot that starts at a pose."""
    map_from_scene = start.inverse()
    for place in places:
        corners = [map_from_scene * Pose2D(x, y, 0.0) for x, y in place.polygon]
        yield place.name, [(corner.x, corner.y) for corner in corners]


def is_in(place: Place, point: tuple[float, float]) -> bool:
    """Whether a point is in a room, a rectangle along the axes."""
    (x0, y0), (x1, y1) = place.polygon[0], place.polygon[2]
    return x0 <= point[0] <= x1 and y0 <= point[1] <= y1


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
            rooms = places_of_scene(Scene.load(scene))
            for name, corners in in_map(rooms, episode.start):
                robot.name_place(name, corners)
            result = robot.execute_instruction(text, timeout=TIMEOUT)
            assert robot.simulation is not None
            pose = robot.simulation.true_pose()
            return {
                "place": place,
                "text": text,
                "reason": result.reason,
                "detail": result.detail,
                "right_room": any(is_in(room, episode.end) and is_in(room, (pose.x, pose.y)) for room in rooms),
                "success": bool(result.success and task.is_success(episode, (pose.x, pose.y))),
                "verified": result.verified,
                "collision_speed": robot.simulation.max_collision_speed(),
                "duration": result.duration,
            }


def go_to(seed: int, place: str) -> Case:
    """ "go to the PLACE", one of a scene's rooms, from anywhere: the map and the places are given, as files."""
    draw = random.Random(seed)
    with scene_of(place, seed) as scene, tempfile.TemporaryDirectory() as folder:
        files = threewe.export(scene, "3we_standard_v2", "map", folder, places=True)
        assert [file.name for file in files] == ["map.pgm", "map.yaml", "places.yaml"]
        tables = SceneTables(Scene.load(scene), RobotProfile.load("3we_standard_v2"))
        start = tables.sample_free_pose(draw.randrange(2**31))
        goal = draw.choice([room for room in places_of_scene(Scene.load(scene)) if not is_in(room, (start.x, start.y))])
        given = {"map": Path(folder) / "map.yaml", "initial_pose": start}
        with sync.Robot(scene=scene, seed=seed, start_pose=start, **given) as robot:
            robot.load_places(Path(folder) / "places.yaml")
            result = robot.execute_instruction(f"go to the {goal.name}", timeout=TIMEOUT)
            assert robot.simulation is not None
            pose = robot.simulation.true_pose()
            return {
                "place": place,
                "goal": goal.name,
                "reason": result.reason,
                "detail": result.detail,
                "success": bool(result.success and is_in(goal, (pose.x, pose.y))),
                "collision_speed": robot.simulation.max_collision_speed(),
                "duration": result.duration,
            }
