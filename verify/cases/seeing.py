"""What the object detector says of pictures from places that it has not seen, against what truly is in them."""

from __future__ import annotations

import asyncio
import math
from collections import Counter
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray
from threewe import Pose2D, Robot, Scene, TickView, sync
from threewe._core import Detection, Detector, Object, SemanticImage, color_names, color_of
from threewe.benchmark.unseen import SUFFIX, extent_of, unseen_scene

from verify.harness import Case

GENERATED = "generated"
PICTURES = 10  # of a case
CONFIDENCE = 0.7  # from which a detection is taken to name its kind
LEAST_PIXELS = 200  # of 640 x 480, of a thing that is to be found
FARTHEST = 5.0  # [m] of it
PROBABLE = 0.5  # least probability of its kind, of an entry of the map
NEAR = 0.4  # [m] of what a thing covers of the floor, within which an entry of the map is of it
TICK = 0.02  # [s]
LOOK_EVERY = 25  # ticks
SHOWN = 0.3  # of a thing's pixels, at least, that are within the box of a detection of it

DETECTOR = Detector.load()


def see(seed: int, scene: str) -> Case:
    """Kinds and colors in the pictures of a robot's camera at free poses, noise and all."""
    with TemporaryDirectory() as folder:
        if scene.endswith(SUFFIX):
            path = Path(folder, f"{scene}.yaml")
            path.write_text(unseen_scene(scene), encoding="utf-8")
            scene = str(path)
        robot = sync.Robot(scene=scene, seed=seed, localization="truth")
    counts = dict.fromkeys(("named", "right", "things", "found", "colors", "colors_right"), 0)
    with robot:
        for i in range(PICTURES):
            robot.simulation.reset(seed=seed, episode=i, pose=robot.simulation.sample_free_pose(seed + i))
            picture = robot.get_image()
            truth = robot.simulation.look()
            for name, count in judged(DETECTOR.detect(picture, truth.intrinsics), truth, kinds(robot)).items():
                counts[name] += count
    return {"scene": Path(scene).stem, **counts}


def kinds(robot: sync.Robot) -> dict[str, str]:
    """The kind of each thing, by its name."""
    things = {thing.name: thing.category for thing in robot.simulation.scene.objects}
    return things | {person.name: "person" for person in robot.simulation.people()}


def judged(detections: list[Detection], truth: SemanticImage, kind_of: dict[str, str]) -> dict[str, int]:
    """How many of the detections name a kind, and rightly; of the things, and are found; have the right color.

    What is smaller or farther away than asked is no error where it is found.
    """
    things = {
        id_: kind_of[name] for id_, name in enumerate(truth.names) if name in kind_of and np.any(truth.ids == id_)
    }
    wanted = {id_ for id_ in things if is_wanted(truth, id_)}
    found: set[int] = set()
    counts = dict.fromkeys(("named", "right", "things", "found", "colors", "colors_right"), 0)
    for detection in detections:
        if detection.confidence < CONFIDENCE:
            continue
        shown = the_shown(detection, truth, things, DETECTOR.labels[detection.kind_index])
        if shown is None or shown in wanted:
            counts["named"] += 1
        if shown not in wanted:
            continue
        counts["right"] += 1
        if shown not in found:
            found.add(shown)
            counts["colors"] += 1
            counts["colors_right"] += detection.color == true_color(truth, shown)
    return {**counts, "things": len(wanted), "found": len(found)}


def is_wanted(truth: SemanticImage, id_: int) -> bool:
    """Whether a thing is large and near enough."""
    shown = truth.ids == id_
    return np.count_nonzero(shown) >= LEAST_PIXELS and float(np.median(truth.depth[shown])) <= FARTHEST


def the_shown(detection: Detection, truth: SemanticImage, things: dict[int, str], kind: str) -> int | None:
    """The thing of that kind that the box of a detection shows the most of; none where it shows none."""
    x_min, y_min, x_max, y_max = detection.box
    inside = np.bincount(truth.ids[y_min:y_max, x_min:x_max].ravel(), minlength=len(truth.names))
    all_of_it = np.bincount(truth.ids.ravel(), minlength=len(truth.names))
    fit = [id_ for id_ in things if things[id_] == kind and inside[id_] >= SHOWN * all_of_it[id_]]
    return max(fit, key=lambda id_: int(inside[id_]), default=None)


def true_color(truth: SemanticImage, id_: int) -> str:
    """The color term that most of a thing's pixels have, without noise."""
    return color_names()[int(np.argmax(np.bincount(terms_of(truth.color[truth.ids == id_]))))]


def terms_of(colors: NDArray[np.uint8]) -> NDArray[np.int64]:
    """The index of the color term of each of (..., 3) colors."""
    return terms()[_packed(colors)]


def _packed(colors: NDArray[np.uint8]) -> NDArray[np.int64]:
    """The index of (..., 3) colors in `terms`."""
    coarse = colors.astype(np.int64) >> 3
    packed: NDArray[np.int64] = (coarse[..., 0] << 10) | (coarse[..., 1] << 5) | coarse[..., 2]
    return packed


@cache
def terms() -> NDArray[np.int64]:
    """The index of the color term of each color of 5 bits a channel."""
    names = color_names()
    levels = [(level << 3) + 4 for level in range(32)]
    return np.array([names.index(color_of(b, g, r)) for b in levels for g in levels for r in levels])


def map_things(seed: int, scene: str) -> Case:
    """What a robot knows of things once it has explored, against those that were in its view."""
    if scene != GENERATED:
        return asyncio.run(_map_things(seed, scene))
    random = np.random.default_rng(seed)
    size = (float(random.uniform(9.0, 18.0)), float(random.uniform(8.0, 14.0)))
    with TemporaryDirectory() as folder:
        path = Path(folder, "building.yaml")
        building = Scene.generate(seed, difficulty=float(random.uniform(0.3, 0.9)), size=size)
        path.write_text(building.to_yaml("building"), encoding="utf-8")
        return {**asyncio.run(_map_things(seed, str(path))), "scene": scene}


async def _map_things(seed: int, scene: str) -> Case:
    shown: Counter[str] = Counter()
    async with Robot(scene=scene, seed=seed) as robot:
        simulation = robot.simulation
        assert simulation is not None
        ticks = 0

        def look(_: TickView) -> None:
            nonlocal ticks
            ticks += 1
            if ticks % LOOK_EVERY == 0:
                truth = simulation.look()
                shown.update(truth.names[id_] for id_ in np.unique(truth.ids) if is_wanted(truth, int(id_)))

        robot.observe(look)
        result = await robot.execute_instruction("explore", timeout=900.0)
        mapped = [thing for thing in robot.get_things() if max(thing.kinds) >= PROBABLE]
        true_from_map = simulation.true_pose() * robot.get_pose().inverse()
        things = simulation.scene.objects
    known = [(DETECTOR.labels[one.kind_index], true_from_map * Pose2D(*one.position, 0.0)) for one in mapped]
    seen = [thing for thing in things if shown[thing.name] >= 1.0 / (LOOK_EVERY * TICK)]
    return {
        "scene": scene,
        "reason": result.reason,
        "entries": len(known),
        "right": sum(any(is_of(*entry, thing) for thing in things) for entry in known),
        "things": len(seen),
        "known": sum(any(is_of(*entry, thing) for entry in known) for thing in seen),
    }


def is_of(kind: str, at: Pose2D, thing: Object) -> bool:
    """Whether an entry of the map is of that kind, and within 0.4 m of what the thing covers of the floor."""
    local = thing.pose.inverse() * at
    x_min, y_min, x_max, y_max = extent_of(thing.category, thing.shape)
    away = max(x_min - local.x, local.x - x_max, 0.0), max(y_min - local.y, local.y - y_max, 0.0)
    return kind == thing.category and math.hypot(*away) <= NEAR
