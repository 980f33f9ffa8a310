"""Scenes with other furniture: each object of a named scene is replaced by a held-out shape of its category.

Held-out shapes stand in no named scene and in no generated building: what was trained there has never seen them.
"""

from __future__ import annotations

import math
import re
from functools import cache
from pathlib import Path

from threewe._core import Scene, asset_directories, unknown_name
from threewe._files import read_text
from threewe.errors import ConfigError

HELD_OUT = {
    "bed": ("cot", "platform"),
    "chair": ("shell", "folding"),
    "couch": ("settee", "futon"),
    "desk": ("trestle", "lift"),
    "monitor": ("tube", "upright"),
    "plant": ("cactus", "bush"),
    "refrigerator": ("minibar", "display"),
    "shelf": ("ladder", "cubes", "cantilever"),
    "table": ("bistro", "farm"),
}
"""By category. Doors stay: they are only trained on."""

OF = ("office_v2", "apartment_v1", "warehouse_v1", "cluttered_v1")
SUFFIX = "_unseen"
OBJECT = re.compile(r"category: (\w+), shape: (\w+)")
ALIKE = 0.5  # of the largest that fits: shapes with so much of its area take turns
SLACK = 0.01  # [m] that a shape may be larger

Extent = tuple[float, float, float, float]
"""x and y from, x and y to [m], in the object's frame."""


def unseen_scene(name: str) -> str:
    """The YAML of a scene `NAME_unseen`. Raises ConfigError for a scene that has none."""
    if name not in [f"{scene}{SUFFIX}" for scene in OF]:
        raise ConfigError(unknown_name("unseen scene", name, [f"{scene}{SUFFIX}" for scene in OF]))
    original = name.removesuffix(SUFFIX)
    [path] = [path for folder in asset_directories() if (path := Path(folder, f"scenes/{original}.yaml")).exists()][:1]
    turns = dict.fromkeys(HELD_OUT, 0)

    def replaced(match: re.Match[str]) -> str:
        category, shape = match.groups()
        if category not in HELD_OUT:
            return match[0]
        turns[category] += 1
        return f"category: {category}, shape: {replacement(category, shape, turns[category])}"

    text = OBJECT.sub(replaced, read_text(path))
    return re.sub(rf"^name: {original}$", f"name: {name}", text, flags=re.M)


def replacement(category: str, shape: str, turn: int) -> str:
    """The held-out shape in place of another: of those that fit there the largest, or one about as large."""
    fitting = [held for held in HELD_OUT[category] if _fits(extent_of(category, held), extent_of(category, shape))]
    if not fitting:
        return min(HELD_OUT[category], key=lambda held: _area(extent_of(category, held)))
    largest = max(_area(extent_of(category, held)) for held in fitting)
    alike = [held for held in fitting if _area(extent_of(category, held)) >= ALIKE * largest]
    return alike[turn % len(alike)]


@cache
def extent_of(category: str, shape: str) -> Extent:
    """What a shape fills, seen from above."""
    text = (
        "name: depot\ndescription: one thing\nstarts: [[-4, -4]]\n"
        "walls: [{a: [-5, -5], b: [5, -5]}, {a: [5, -5], b: [5, 5]}]\n"
        f"objects: [{{category: {category}, shape: {shape}, pose: [0, 0]}}]\n"
    )
    [thing] = Scene.parse(text, f"{category}/{shape}").objects
    corners = [corner for prism in thing.prisms for corner in prism.outline()]
    xs, ys = [x for x, _ in corners], [y for _, y in corners]
    return min(xs), min(ys), max(xs), max(ys)


def _fits(inner: Extent, outer: Extent) -> bool:
    lower = all(a >= b - SLACK for a, b in zip(inner[:2], outer[:2], strict=True))
    return lower and all(a <= b + SLACK for a, b in zip(inner[2:], outer[2:], strict=True))


def _area(extent: Extent) -> float:
    return math.prod(high - low for low, high in zip(extent[:2], extent[2:], strict=True))
