"""Buildings that differ more than those of `Scene.generate`: large rooms, rows of shelves, more things, other shapes.

Detectors and policies learn in them. No shape that is held out stands there.
"""

from __future__ import annotations

import itertools
import json
import math
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml  # type: ignore[import-untyped]

from threewe._core import Scene, asset_directories
from threewe.benchmark.unseen import HELD_OUT, Extent, extent_of
from threewe.errors import ConfigError

OTHER_SHAPE = 0.7  # of the furniture that is given another shape of its kind
HALLS = 0.5  # of the buildings are halls, full of rows and of things in no order
FREE = 1.0  # [m] around where robots start
AT_WALL = 0.6  # of the things that are added
OFF_WALL = 0.12  # [m] of a thing's back from the middle of a wall
MARGIN = 0.03  # [m] between things
IN_ROWS = ("pallet_rack", "picking", "wide", "metal", "bookcase", "low", "lockers", "wardrobe", "tall", "double")
FLOORS = ("wood", "tile", "carpet", "concrete", "vinyl")
MORE = (
    *("door", "shelf", "cabinet", "refrigerator") * 3,  # those that are taken for each other
    *("bed", "box", "chair", "column", "couch", "counter", "desk", "plant", "table") * 2,
    "tree",
)
"""Kinds of what is added, as often as they stand here."""


def varied_building(random: np.random.Generator, seed: int, people: int = 0) -> str:
    """The YAML of a generated building or a hall, with more things, as often at walls as not, and so many people."""
    content = _hall(random) if random.random() < HALLS else _furnished(random, seed)
    area = sum((room["max"][0] - room["min"][0]) * (room["max"][1] - room["min"][1]) for room in content["rooms"])
    shapes = shapes_by_kind()
    taken = _Taken(content)
    for _ in range(int(area * random.uniform(0.05, 0.3))):
        kind = str(random.choice(MORE))
        taken.add(kind, str(random.choice(shapes[kind])), _place(random, content, at_wall=random.random() < AT_WALL))
    content["people"] = []
    for i in range(people):
        x, y, _ = _place(random, content, at_wall=False)
        if taken.is_free((x - 0.3, y - 0.3, x + 0.6, y + 0.3)):
            content["people"].append({"name": f"person_{i}", "speed": 1.0, "route": [[x, y], [x + 0.3, y]]})
    return _without_what_overlaps(content)


def _furnished(random: np.random.Generator, seed: int) -> dict[str, Any]:
    """A generated building, its furniture replaced by other shapes of the same kinds."""
    size = (float(random.uniform(9, 24)), float(random.uniform(8, 18)))
    scene = Scene.generate(seed, difficulty=float(random.uniform(0.1, 0.95)), size=size)
    content: dict[str, Any] = yaml.safe_load(scene.to_yaml("building"))
    shapes = shapes_by_kind()
    for i, thing in enumerate(content["objects"]):
        thing.setdefault("name", f"thing_{i}")
        if random.random() < OTHER_SHAPE:
            thing["shape"] = str(random.choice(shapes[thing["category"]]))
    height = float(random.uniform(2.3, 4.0))
    for wall in content["walls"]:
        wall["height"] = height
    return content


def _hall(random: np.random.Generator) -> dict[str, Any]:
    """One large room, or two with a door between them; in every other one things stand in rows."""
    width, depth = float(random.uniform(9, 26)), float(random.uniform(8, 16))
    height = float(random.uniform(2.5, 6.0))
    split = width * float(random.uniform(0.3, 1.4))
    corners = [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)]
    walls: list[dict[str, Any]] = [
        {"a": list(a), "b": list(b), "thickness": 0.2} for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    ends = [0.0, split, width] if split < width - 3 else [0.0, width]
    if len(ends) == 3:
        door = {"name": "door_1", "at": depth * float(random.uniform(0.2, 0.8)), "width": 1.2}
        walls.append({"a": [split, 0.0], "b": [split, depth], "doors": [door]})
    rooms = [
        {"name": f"hall_{i}", "min": [low, 0.0], "max": [high, depth], "floor": str(random.choice(FLOORS))}
        for i, (low, high) in enumerate(itertools.pairwise(ends))
    ]
    for wall in walls:
        wall["height"] = height
    start = [float(random.uniform(1, ends[1] - 1)), float(random.uniform(1, depth - 1)), 0.0]
    content: dict[str, Any] = {"name": "building", "description": "A hall", "starts": [start]}
    content |= {"rooms": rooms, "walls": walls, "objects": []}
    if random.random() < 0.5:
        _add_rows(random, content, ends[1], depth)
    return content


def _add_rows(random: np.random.Generator, content: dict[str, Any], width: float, depth: float) -> None:
    """Rows of shelves, cabinets or refrigerators, with aisles between them, some back to back."""
    kind_of = {shape: kind for kind in ("shelf", "cabinet", "refrigerator") for shape in shapes_by_kind()[kind]}
    taken = _Taken(content)
    y = float(random.uniform(0.6, 2.0))
    side = 1
    while y < depth - 0.6:
        shape = str(random.choice(IN_ROWS))
        x_min, y_min, x_max, y_max = extent_of(kind_of[shape], shape)
        x = float(random.uniform(0.3, 2.0)) + (y_max - y_min) / 2
        while x < width - (y_max - y_min) / 2 - 0.3:
            if random.random() < 0.85:
                taken.add(kind_of[shape], shape, (x, y + (x_max - x_min) / 2, side * math.pi / 2))
            x += y_max - y_min + float(random.choice([0.04, random.uniform(0.04, 1.5)]))
        back_to_back = side < 0 and random.random() < 0.7
        y += x_max - x_min + (0.1 if back_to_back else float(random.uniform(1.2, 2.6)))
        side = -side


def _place(random: np.random.Generator, content: dict[str, Any], *, at_wall: bool) -> tuple[float, float, float]:
    """Where a thing is to stand: at a wall, its back to it, or anywhere in a room."""
    room = content["rooms"][random.integers(len(content["rooms"]))]
    low, high = room["min"], room["max"]
    x, y = (float(random.uniform(low[k] + 0.4, high[k] - 0.4)) for k in (0, 1))
    side = int(random.integers(4))
    angle = side * math.pi / 2 + (float(random.normal(0, 0.05)) if random.random() < 0.5 else 0.0)
    if not at_wall:
        return x, y, angle if random.random() < 0.4 else float(random.uniform(-math.pi, math.pi))
    x, y = [(low[0], y), (x, low[1]), (high[0], y), (x, high[1])][side]
    return x, y, angle


class _Taken:
    """The floor that the things of a scene cover, as boxes along its axes."""

    def __init__(self, content: dict[str, Any]) -> None:
        self.content = content
        self.boxes = [self._box(one["category"], one["shape"], one["pose"]) for one in content["objects"]]
        for x, y, _ in content["starts"]:
            self.boxes.append((x - FREE, y - FREE, x + FREE, y + FREE))

    @staticmethod
    def _box(kind: str, shape: str, pose: Sequence[float]) -> Extent:
        x_min, y_min, x_max, y_max = extent_of(kind, shape)
        c, s = math.cos(pose[2]), math.sin(pose[2])
        corners = [(c * x - s * y, s * x + c * y) for x in (x_min, x_max) for y in (y_min, y_max)]
        xs, ys = [pose[0] + x for x, _ in corners], [pose[1] + y for _, y in corners]
        return min(xs), min(ys), max(xs), max(ys)

    def is_free(self, box: Extent) -> bool:
        """Whether nothing stands in a box."""
        return all(
            box[2] + MARGIN < other[0]
            or other[2] + MARGIN < box[0]
            or box[3] + MARGIN < other[1]
            or other[3] + MARGIN < box[1]
            for other in self.boxes
        )

    def add(self, kind: str, shape: str, place: tuple[float, float, float]) -> None:
        """Adds a thing, its back at a point, where the floor is free."""
        x, y, angle = place
        off = OFF_WALL - extent_of(kind, shape)[0]
        pose = [x + off * math.cos(angle), y + off * math.sin(angle), angle]
        box = self._box(kind, shape, pose)
        if self.is_free(box):
            self.boxes.append(box)
            name = f"added_{len(self.boxes)}"
            self.content["objects"].append({"category": kind, "shape": shape, "pose": pose, "name": name})


def _without_what_overlaps(content: dict[str, Any]) -> str:
    """The scene as text, less the things and people that do not fit: errors name them."""
    while True:
        text = json.dumps(content)  # which is YAML too, and read faster
        try:
            Scene.parse(text, "building")
        except ConfigError as error:
            names = [str(thing["name"]) for key in ("objects", "people") for thing in content[key]]
            found = [name for name in re.findall(r"'(\w+)'", str(error)) if name in names]
            if not found:
                raise
            for key in ("objects", "people"):
                content[key] = [thing for thing in content[key] if thing["name"] != found[0]]
        else:
            return text


@cache
def shapes_by_kind() -> dict[str, list[str]]:
    """The shapes of each kind that are not held out."""
    shapes: dict[str, list[str]] = {}
    for folder in asset_directories():
        for path in sorted(Path(folder, "objects").glob("*.yaml")):
            content = yaml.safe_load(path.read_text(encoding="utf-8"))
            held_out = HELD_OUT.get(content["category"], ())
            shapes[content["category"]] = [shape for shape in content["shapes"] if shape not in held_out]
    return shapes
