"""Features of a LeRobot dataset: what each column or camera is called, its type and shape, checked as data."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from threewe.errors import ConfigError

NUMBERS = ("float32", "float64", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "bool")
DTYPES = (*NUMBERS, "string", "image", "video")
LARGEST_SIDE = 16_384
"""[pixels] of an image: more than any camera has, and the most that H.264 and AV1 name."""
LARGEST_FEATURE = 2**24
"""Numbers in one row of a column: a map of 4096 x 4096 cells."""
LARGEST_COUNT = 2**40
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.\- ]{0,199}")


@dataclass(frozen=True)
class Feature:
    """A column (numbers, strings, images in the table) or a camera (a video beside it).

    `shape` is that of one row: `(3,)` for a velocity, `(480, 640, 3)` for a camera, `(480, 640, 1)` for its depth.
    `names` are those of its entries, as LeRobot keeps them; `info` is what LeRobot says about a camera's encoding.
    """

    dtype: str
    shape: tuple[int, ...]
    names: Any = None
    info: Mapping[str, Any] = field(default_factory=dict)

    @property
    def is_camera(self) -> bool:
        """Images, in the table or in a video."""
        return self.dtype in ("image", "video")

    @property
    def is_depth(self) -> bool:
        """Depth in millimetres, 16 bits a pixel, instead of colours."""
        return bool(self.info.get("is_depth_map") or self.info.get("video.is_depth_map"))

    @property
    def mount(self) -> tuple[Any, Any] | None:
        """Where its sensor is, x, y [m], theta [rad] and height [m] on the robot; None where that is not noted."""
        place = self.info.get("base_from_sensor"), self.info.get("height")
        return None if None in place else place

    @property
    def levels_per_unit(self) -> float:
        """What statistics divide an image by: 255; depth, which is in mm, by 1, or by 1000 where it notes metres."""
        if not self.is_depth:
            return 255.0
        return 1000.0 if self.info.get("depth_unit") == "m" else 1.0

    def to_json(self) -> dict[str, Any]:
        """As `meta/info.json` has it."""
        entry: dict[str, Any] = {"dtype": self.dtype, "shape": list(self.shape), "names": self.names}
        return {**entry, "info": dict(self.info)} if self.info else entry


DEFAULT_FEATURES: Mapping[str, Feature] = {
    "timestamp": Feature("float32", (1,)),
    "frame_index": Feature("int64", (1,)),
    "episode_index": Feature("int64", (1,)),
    "index": Feature("int64", (1,)),
    "task_index": Feature("int64", (1,)),
}
"""The columns that every dataset has, and that the writer fills: seconds, then numbers."""


def parse_features(entries: Any, where: str) -> dict[str, Feature]:
    """Features from JSON or from a caller's dict. Raises ConfigError that names the entry."""
    if not isinstance(entries, Mapping):
        raise ConfigError(f"{where}: features must be a mapping of names, not {type(entries).__name__}")
    if len(entries) > 1000:
        raise ConfigError(f"{where}: {len(entries)} features; at most 1000 are read")
    return {
        require_name(name, where): parse_feature(entry, f"{where}: features[{name!r}]")
        for name, entry in entries.items()
    }


def parse_feature(entry: Any, where: str) -> Feature:
    """One feature. Raises ConfigError."""
    if isinstance(entry, Feature):
        entry = entry.to_json()
    if not isinstance(entry, Mapping):
        raise ConfigError(f"{where}: must be a mapping with dtype and shape, not {type(entry).__name__}")
    dtype = entry.get("dtype")
    if dtype not in DTYPES:
        raise ConfigError(f"{where}: dtype {dtype!r:.60} is not read; known are {', '.join(DTYPES)}")
    shape = parse_shape(entry.get("shape"), dtype, where)
    info = entry.get("info") or entry.get("video_info") or {}
    if not isinstance(info, Mapping):
        raise ConfigError(f"{where}: info must be a mapping, not {type(info).__name__}")
    feature = Feature(dtype, shape, entry.get("names"), dict(info))
    if feature.is_camera:
        feature = Feature(dtype, camera_shape(feature, where), feature.names, feature.info)
    return feature


def parse_shape(shape: Any, dtype: str, where: str) -> tuple[int, ...]:
    """Positive lengths. Raises ConfigError."""
    if not isinstance(shape, (list, tuple)) or not 1 <= len(shape) <= 5:
        raise ConfigError(f"{where}: shape must be a list of 1 to 5 lengths, not {shape!r:.60}")
    if any(type(length) is not int or not 1 <= length <= LARGEST_FEATURE for length in shape):
        raise ConfigError(f"{where}: shape {shape!r:.60} must hold integers from 1 to {LARGEST_FEATURE}")
    if dtype in NUMBERS and math.prod(shape) > LARGEST_FEATURE:
        raise ConfigError(f"{where}: shape {shape!r:.60} has more than {LARGEST_FEATURE} numbers a row")
    if dtype == "string" and tuple(shape) != (1,):
        raise ConfigError(f"{where}: a string has shape [1], not {shape!r:.60}")
    return tuple(shape)


def camera_shape(feature: Feature, where: str) -> tuple[int, int, int]:
    """(height, width, channels), whichever order LeRobot was given. Raises ConfigError."""
    shape, channels = feature.shape, (1,) if feature.is_depth else (3,)
    if len(shape) == 3 and shape[0] in channels and shape[2] not in channels:
        shape = (shape[1], shape[2], shape[0])
    if len(shape) != 3 or shape[2] not in channels or max(shape) > LARGEST_SIDE:
        kind = "depth image has shape [height, width, 1]" if feature.is_depth else "camera has shape [height, width, 3]"
        raise ConfigError(f"{where}: a {kind} with sides up to {LARGEST_SIDE}, not {list(feature.shape)}")
    return shape[0], shape[1], shape[2]


def require_name(name: Any, where: str) -> str:
    """A feature's name, which becomes that of a folder. Raises ConfigError."""
    if not isinstance(name, str) or not NAME.fullmatch(name) or ".." in name:
        rule = "letters, digits, '_', '-' and single '.' in the middle, at most 200"
        raise ConfigError(f"{where}: {name!r:.80} is no name of a feature: {rule}")
    return name
