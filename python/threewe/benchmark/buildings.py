"""Buildings that a name stands for: `building-SEED` is drawn from its seed, style and size too."""

from __future__ import annotations

import atexit
import hashlib
import random
import re
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from threewe._core import Scene

WIDTHS = (10.0, 32.0)  # [m], drawn from these
DEPTHS = (8.0, 20.0)  # [m]
NAME = re.compile(r"building-(\d{1,20})")


def building_name(key: str) -> str:
    """The name of the building that a text leads to: the same everywhere, and no way back to the text."""
    return f"building-{int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], 'big')}"


def scene_asset(name: str) -> str:
    """What `Robot(scene=...)` takes for a scene of an episode: its name, or the file of a generated building."""
    return str(_drawn(name)) if NAME.fullmatch(name) else name


def load_scene(name: str) -> Scene:
    """A scene of an episode."""
    return Scene.load(scene_asset(name))


@cache
def _folder() -> Path:
    folder = TemporaryDirectory(prefix="threewe-buildings-")
    atexit.register(folder.cleanup)
    return Path(folder.name)


@cache
def _drawn(name: str) -> Path:
    seed = int(name.removeprefix("building-"))
    draw = random.Random(seed)
    size = draw.uniform(*WIDTHS), draw.uniform(*DEPTHS)
    path = _folder() / f"{name}.yaml"
    path.write_text(Scene.generate(seed % 2**64, difficulty=draw.random(), size=size).to_yaml(name))
    return path
