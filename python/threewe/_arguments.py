"""What a program passed, as the types that the core takes. A wrong one raises ContractError naming the argument."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from typing import SupportsIndex, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from threewe._core import Pose2D
from threewe.errors import ContractError

PoseLike: TypeAlias = Pose2D | Sequence[float]


def as_text(name: str, value: str) -> str:
    """A string. Raises ContractError."""
    if not isinstance(value, str):
        raise ContractError(f"{name} must be a string, got {value!r}")
    return value


def as_switch(name: str, value: bool) -> bool:
    """True or False. Raises ContractError."""
    if not isinstance(value, bool | np.bool_):
        raise ContractError(f"{name} must be True or False, got {value!r}")
    return bool(value)


def as_seed(name: str, value: SupportsIndex) -> int:
    """A whole number from 0 to 2**64 - 1. Raises ContractError."""
    try:
        seed = operator.index(value)
    except TypeError:
        seed = -1
    if not 0 <= seed < 2**64:
        raise ContractError(f"{name} must be a whole number in [0, 2**64), got {value!r}")
    return seed


def as_number(name: str, value: float) -> float:
    """A finite number. Raises ContractError."""
    try:
        number = math.fsum([value])  # unlike float() takes no text
    except (TypeError, ValueError):
        raise ContractError(f"{name} must be a number, got {value!r}") from None
    if not math.isfinite(number):
        raise ContractError(f"{name} must be finite, not {number}")
    return number


def as_pose(name: str, pose: PoseLike) -> Pose2D:
    """A Pose2D from one, from (x, y) or from (x, y, theta). Raises ContractError."""
    if isinstance(pose, Pose2D):
        return pose
    numbers = as_array(name, pose, (None,)).tolist()
    if len(numbers) not in (2, 3):
        raise ContractError(f"{name} must be a Pose2D, (x, y) or (x, y, theta), got {pose!r}")
    return Pose2D(*numbers)


def as_array(name: str, values: ArrayLike, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
    """A finite array of some shape, where None is any length. Raises ContractError."""
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError) as error:
        raise ContractError(f"{name} must hold numbers, got {values!r}") from error
    fits = len(array.shape) == len(shape)
    if not fits or any(want not in (None, got) for got, want in zip(array.shape, shape, strict=True)):
        wanted = ", ".join("N" if length is None else str(length) for length in shape)
        raise ContractError(f"{name} must have shape ({wanted}), got {array.shape}")
    if not np.isfinite(array).all():
        raise ContractError(f"{name} must be finite, got {array.tolist()}")
    return array
