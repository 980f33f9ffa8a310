"""Episodes for the tests of LeRobot datasets."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threewe.data.lerobot import ArrayFrames, DatasetWriter, FrameSource, PacketFrames
from threewe.data.video import KeyFrameEncoder

FPS = 10
CAMERA, STILL = "observation.images.front", "observation.images.map"
DEPTH, DEPTH_VIDEO = "observation.images.depth", "observation.images.depth_video"
SIZE = (48, 64)
IMAGE = ["height", "width", "channels"]
NUMBERS: dict[str, dict[str, Any]] = {
    "observation.state": {"dtype": "float32", "shape": [3], "names": ["x", "y", "theta"]},
    "action": {"dtype": "float32", "shape": [2], "names": ["v", "omega"]},
    "next.success": {"dtype": "bool", "shape": [1], "names": None},
}
MORE: dict[str, dict[str, Any]] = {
    "precise": {"dtype": "float64", "shape": [1], "names": None},
    "grid": {"dtype": "float32", "shape": [3, 4], "names": None},
    "bumps": {"dtype": "int64", "shape": [2], "names": None},
    "note": {"dtype": "string", "shape": [1], "names": None},
}
CAMERAS: dict[str, dict[str, Any]] = {
    CAMERA: {"dtype": "video", "shape": [*SIZE, 3], "names": IMAGE},
    STILL: {"dtype": "image", "shape": [16, 24, 3], "names": IMAGE},
    DEPTH: {"dtype": "image", "shape": [16, 24, 1], "names": IMAGE, "info": {"is_depth_map": True}},
    DEPTH_VIDEO: {"dtype": "video", "shape": [*SIZE, 1], "names": IMAGE, "info": {"is_depth_map": True}},
}
SMALL = {**NUMBERS, CAMERA: CAMERAS[CAMERA]}
EVERYTHING = {**NUMBERS, **MORE, **CAMERAS}


def episode(rng: np.random.Generator, length: int, success: bool = True) -> dict[str, NDArray[Any]]:
    """Arrays of every feature."""
    blocks = rng.integers(0, 256, (length, SIZE[0] // 8, SIZE[1] // 8, 3), np.uint8)
    return {
        "observation.state": rng.normal(size=(length, 3)).astype(np.float32),
        "action": rng.uniform(-1, 1, (length, 2)).astype(np.float32),
        "next.success": (np.arange(length) == length - 1) & success,
        "precise": rng.normal(size=length),
        "grid": rng.normal(size=(length, 3, 4)).astype(np.float32),
        "bumps": rng.integers(-9, 9, (length, 2)),
        "note": np.array([f"note {i}" for i in range(length)], dtype=object),
        CAMERA: np.repeat(np.repeat(blocks, 8, 1), 8, 2),
        STILL: rng.integers(0, 256, (length, 16, 24, 3), np.uint8),
        DEPTH: rng.integers(0, 65536, (length, 16, 24)).astype(np.uint16),
        DEPTH_VIDEO: rng.integers(300, 9000, (length, *SIZE)).astype(np.uint16),
    }


def packets(images: NDArray[np.uint8]) -> PacketFrames:
    """Images as a recorder has them."""
    shape = (images.shape[1], images.shape[2], 3)
    encoder = KeyFrameEncoder(shape, "rgb24")
    return PacketFrames([encoder.encode(image) for image in images], shape)


def add(writer: DatasetWriter, given: dict[str, NDArray[Any]], task: str = "go", copied: bool = True) -> None:
    """Adds an episode's arrays, as far as the writer has features for them."""
    names = writer.info.features.keys() & given.keys()
    cameras: dict[str, FrameSource] = {name: ArrayFrames(given[name]) for name in names & CAMERAS.keys()}
    if copied and CAMERA in cameras:
        cameras[CAMERA] = packets(given[CAMERA])
    writer.add_episode({name: given[name] for name in names - CAMERAS.keys()}, task, cameras)


def write(
    root: Path,
    seed: int,
    lengths: tuple[int, ...] = (9, 12, 7),
    tasks: tuple[str, ...] = ("go", "stop", "go"),
    features: dict[str, dict[str, Any]] = SMALL,
    **options: Any,
) -> list[dict[str, NDArray[Any]]]:
    """Writes a dataset; what is in it. Of three episodes the second failed."""
    rng = np.random.default_rng(seed)
    made = [episode(rng, length, success=i != 1) for i, length in enumerate(lengths)]
    with DatasetWriter(root, fps=FPS, features=features, robot_type="3we", **options) as writer:
        for given, task in zip(made, tasks, strict=True):
            add(writer, given, task, copied=options.get("codec", "copy") == "copy")
    return made
