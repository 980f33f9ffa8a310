"""Scenes that a name stands for: `building-SEED`, drawn from its seed, style and size too, and `SCENE_unseen`."""

from __future__ import annotations

import atexit
import hashlib
import random
import re
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from threewe._core import Scene
from threewe.benchmark.unseen import SUFFIX, unseen_scene

WIDTHS = (10.0, 32.0)  # [m], drawn from these
DEPTHS = (8.0, 20.0)  # [m]
NAME = re.compile(r"building-(\d{1,20})")


def building_name(key: str) -> str:
    """The name of the building that a text leads to: the same everywhere, and no way back to the text."""
    return f"building-{int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], 'big')}"


def scene_asset(name: str) -> str:
    """What `Robot(scene=...)` takes for a scene of an episode: its name, or a file that is written meanwhile."""
    return str(_made(name)) if NAME.fullmatch(name) or name.endswith(SUFFIX) else name


def load_scene(name: str) -> Scene:
    """A scene of an episode."""
    return Scene.load(scene_asset(name))


@cache
def _folder() -> Path:
    folder = TemporaryDirectory(prefix="threewe-buildings-")
    atexit.register(folder.cleanup)
    return Path(folder.name)


@cache
def _made(name: str) -> Path:
    text = unseen_scene(name) if name.endswith(SUFFIX) else _drawn(name)
    path = _folder() / f"{name}.yaml"
    path.write_text(text)
    return path


def _drawn(name: str) -> str:
    seed = int(name.removeprefix("building-"))
    draw = random.Random(seed)
    size = draw.uniform(*WIDTHS), draw.uniform(*DEPTHS)
    return Scene.generate(seed % 2**64, difficulty=draw.random(), size=size).to_yaml(name)
