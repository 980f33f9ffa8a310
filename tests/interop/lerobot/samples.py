"""Episodes of a robot that never was, with every kind of feature, the same for both sides."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

SIZE = (96, 128)
FPS = 10
TASKS = ("go to the kitchen", "look around", "go to the kitchen")
ROBOT = "3we_standard_v2"
CAMERA = "observation.images.front"
STILL = "observation.images.map"
DEPTH = "observation.images.depth"
DEPTH_VIDEO = "observation.images.depth_video"
IMAGE = ["height", "width", "channels"]
FEATURES: dict[str, dict[str, Any]] = {
    "observation.state": {"dtype": "float32", "shape": [5], "names": ["x", "y", "theta", "v", "w"]},
    "action": {"dtype": "float32", "shape": [3], "names": ["vx", "vy", "omega"]},
    "action.requested": {"dtype": "float64", "shape": [3], "names": ["vx", "vy", "omega"]},
    "observation.grid": {"dtype": "float32", "shape": [4, 6], "names": None},
    "observation.bumps": {"dtype": "int64", "shape": [2], "names": None},
    "next.success": {"dtype": "bool", "shape": [1], "names": None},
    "battery": {"dtype": "float32", "shape": [1], "names": None},
    "note": {"dtype": "string", "shape": [1], "names": None},
    CAMERA: {"dtype": "video", "shape": [*SIZE, 3], "names": IMAGE},
    STILL: {"dtype": "image", "shape": [24, 32, 3], "names": IMAGE},
    DEPTH: {"dtype": "image", "shape": [24, 32, 1], "names": IMAGE, "info": {"is_depth_map": True}},
    DEPTH_VIDEO: {"dtype": "video", "shape": [*SIZE, 1], "names": IMAGE, "info": {"is_depth_map": True}},
}


def episodes(seed: int, lengths: tuple[int, ...] = (20, 23, 17)) -> list[dict[str, NDArray[Any]]]:
    """Arrays of each feature, an episode each."""
    rng = np.random.default_rng(seed)
    return [episode(rng, length) for length in lengths]


def episode(rng: np.random.Generator, length: int) -> dict[str, NDArray[Any]]:
    walk = np.cumsum(rng.normal(size=(length, 5)), axis=0)
    return {
        "observation.state": walk.astype(np.float32),
        "action": rng.uniform(-0.5, 0.5, (length, 3)).astype(np.float32),
        "action.requested": rng.uniform(-1, 1, (length, 3)),
        "observation.grid": rng.uniform(0, 1, (length, 4, 6)).astype(np.float32),
        "observation.bumps": rng.integers(0, 5, (length, 2)),
        "next.success": np.arange(length) == length - 1,
        "battery": np.linspace(8.4, 7.9, length).astype(np.float32),
        "note": np.array([f"frame {i}" for i in range(length)]),
        CAMERA: pictures(rng, length, SIZE),
        STILL: rng.integers(0, 256, (length, 24, 32, 3), dtype=np.uint8),
        DEPTH: rng.integers(0, 65536, (length, 24, 32)).astype(np.uint16),
        DEPTH_VIDEO: smooth_depth(rng, length, SIZE),
    }


def pictures(rng: np.random.Generator, length: int, size: tuple[int, int]) -> NDArray[np.uint8]:
    """A red box that moves over a wall of changing brightness; no two frames are alike."""
    height, width = size
    y, x = np.mgrid[:height, :width]
    images = np.empty((length, height, width, 3), np.uint8)
    for i in range(length):
        shade = 90 + 60 * np.sin((x + 5 * i) / 25) + 4 * i
        images[i] = np.clip(shade[..., None] * rng.uniform(0.6, 1.0, 3) + y[..., None] / 4, 0, 255)
        left = (3 * i) % (width - 40)
        images[i, 20:60, left : left + 40] = (210, 20, 25)
    return images


def smooth_depth(rng: np.random.Generator, length: int, size: tuple[int, int]) -> NDArray[np.uint16]:
    """Millimetres from 0.3 to 9 m."""
    y, x = np.mgrid[: size[0], : size[1]]
    fields = [300 + 60 * x + 8 * y + rng.integers(0, 200) + 10 * i for i in range(length)]
    return np.array(fields).astype(np.uint16)
