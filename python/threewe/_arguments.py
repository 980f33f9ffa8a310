"""What a program passed, as the types that the core takes. A wrong one raises ContractError naming the argument."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, SupportsIndex, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from threewe._core import OccupancyGrid, Pose2D, load_map
from threewe.errors import ContractError

T = TypeVar("T")
Function = TypeVar("Function", bound=Callable[..., Any])
PoseLike: TypeAlias = Pose2D | Sequence[float]

LONGEST = 1e9
"""[s] that robot time, counted in nanoseconds, can look ahead: 31 years."""


def as_text(name: str, value: str) -> str:
    """A string. Raises ContractError."""
    if not isinstance(value, str):
        raise ContractError(f"{name} must be a string, got {value!r}")
    return value


def as_asset(name: str, value: str | os.PathLike[str]) -> str:
    """The name of a scene or a robot, or the path of its file. Raises ContractError."""
    return as_text(name, os.fspath(value) if isinstance(value, os.PathLike) else value)


def as_file(name: str, value: str | os.PathLike[str]) -> Path:
    """The path of a file or a folder. Raises ContractError."""
    if not isinstance(value, str | os.PathLike):
        raise ContractError(f"{name} must be a path, got {value!r}")
    return Path(value)


def as_switch(name: str, value: bool) -> bool:
    """True or False. Raises ContractError."""
    if not isinstance(value, bool | np.bool_):
        raise ContractError(f"{name} must be True or False, got {value!r}")
    return bool(value)


def as_function(name: str, value: Function) -> Function:
    """Something to call. Raises ContractError."""
    if not callable(value):
        raise ContractError(f"{name} must be a function, got {value!r}")
    return value


def as_list(name: str, values: Iterable[T]) -> list[T]:
    """The items of a list; a string is none. Raises ContractError."""
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise ContractError(f"{name} must be a list, got {values!r}")
    return list(values)


def as_seed(name: str, value: SupportsIndex, bits: int = 64) -> int:
    """A whole number from 0 to 2**bits - 1. Raises ContractError."""
    try:
        seed = operator.index(value)
    except TypeError:
        seed = -1
    if not 0 <= seed < 2**bits:
        raise ContractError(f"{name} must be a whole number in [0, 2**{bits}), got {value!r}")
    return seed


def as_image_size(name: str, value: Sequence[int]) -> tuple[int, int]:
    """Height and width of a picture [px]. Raises ContractError."""
    lengths = as_list(name, value)
    if len(lengths) != 2:
        raise ContractError(f"{name} must be (height, width), got {value!r}")
    height, width = (as_seed(name, length, 16) for length in lengths)
    return height, width


def as_number(name: str, value: float) -> float:
    """A finite number. Raises ContractError."""
    try:
        if isinstance(value, bool | np.bool_) or getattr(value, "ndim", 0) > 0:
            raise TypeError
        number = math.fsum([value])  # unlike float() takes no text
    except (TypeError, ValueError):
        raise ContractError(f"{name} must be a number, got {value!r}") from None
    except OverflowError:  # a whole number that no float can hold
        number = math.inf
    if not math.isfinite(number):
        raise ContractError(f"{name} must be finite, not {number}")
    return number


def as_seconds(name: str, value: float) -> float:
    """A length of time [s]. Raises ContractError."""
    seconds = as_number(name, value)
    if not 0.0 <= seconds <= LONGEST:
        raise ContractError(f"{name} must lie in [0, {LONGEST:g}] s, got {seconds:g}")
    return seconds


def as_pose(name: str, pose: PoseLike) -> Pose2D:
    """A Pose2D from one, from (x, y) or from (x, y, theta). Raises ContractError."""
    if isinstance(pose, Pose2D):
        return pose
    numbers = as_array(name, pose, (None,)).tolist()
    if len(numbers) not in (2, 3):
        raise ContractError(f"{name} must be a Pose2D, (x, y) or (x, y, theta), got {pose!r}")
    return Pose2D(*numbers)


def as_point(name: str, point: PoseLike) -> tuple[float, float]:
    """(x, y), also that of a Pose2D. Raises ContractError."""
    if isinstance(point, Pose2D):
        return point.x, point.y
    x, y = as_array(name, point, (2,)).tolist()
    return x, y


def as_path(name: str, points: ArrayLike | Iterable[PoseLike]) -> list[tuple[float, float]]:
    """A polyline: (N, 2) numbers, or a list in which Pose2Ds stand for their positions. Raises ContractError."""
    if isinstance(points, list | tuple) and any(isinstance(point, Pose2D) for point in points):
        return [as_point(f"{name}[{i}]", point) for i, point in enumerate(points)]
    return [(x, y) for x, y in as_array(name, points, (None, 2)).tolist()]  # type: ignore[arg-type]


def as_waypoints(name: str, places: ArrayLike | Iterable[PoseLike]) -> list[tuple[float, float, float | None]]:
    """Places with a heading or without: (N, 2) or (N, 3) numbers, or a list of poses. Raises ContractError."""
    if not isinstance(places, list | tuple | np.ndarray):
        raise ContractError(f"{name} must be a list of Pose2Ds, (x, y) or (x, y, theta), got {places!r}")
    found: list[tuple[float, float, float | None]] = []
    for i, place in enumerate(places):
        pose = as_pose(f"{name}[{i}]", place)
        headless = not isinstance(place, Pose2D) and len(place) == 2
        found.append((pose.x, pose.y, None if headless else pose.theta))
    return found


def as_map(name: str, value: OccupancyGrid | str | os.PathLike[str]) -> OccupancyGrid:
    """A map, or the one in a file that ends in .yaml. Raises ContractError, ConfigError."""
    if isinstance(value, OccupancyGrid):
        return value
    if not isinstance(value, str | os.PathLike):
        raise ContractError(f"{name} must be an OccupancyGrid or the path of a .yaml file, got {value!r}")
    return load_map(as_asset(name, value))


def as_array(name: str, values: ArrayLike, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
    """A finite array of some shape, where None is any length. Raises ContractError."""
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "iuf":  # numpy would read numbers out of text
            raise TypeError
    except (TypeError, ValueError):
        raise ContractError(f"{name} must hold numbers, got {values!r}") from None
    fits = len(array.shape) == len(shape)
    if not fits or any(want not in (None, got) for got, want in zip(array.shape, shape, strict=True)):
        lengths = ", ".join("N" if length is None else str(length) for length in shape)
        wanted = f"({lengths},)" if len(shape) == 1 else f"({lengths})"
        raise ContractError(f"{name} must have shape {wanted}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ContractError(f"{name} must be finite, got {array.tolist()}")
    return array.astype(np.float64)
