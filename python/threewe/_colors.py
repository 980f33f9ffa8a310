"""Colours of maps, wherever they are drawn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from threewe._core import OccupancyGrid

Color = tuple[int, int, int, int]

INK: Color = (38, 44, 56, 255)
UNKNOWN: Color = (214, 219, 226, 255)
NOTHING: Color = (0, 0, 0, 0)


def map_colors(grid: OccupancyGrid, unknown: Color = UNKNOWN) -> NDArray[np.uint8]:
    """A robot's own map as a picture, (H, W, 4) RGBA, row 0 the highest y: free white, occupied dark."""
    # of cells by their value: 0 free to 100 occupied, then -1 unknown
    known = [[round(255 + (c - 255) * value / 100) for c in INK] for value in range(101)]
    return np.array([*known, unknown], np.uint8)[grid.data[::-1]]


def depth_colors(depth: NDArray[np.float32], low: float, high: float) -> NDArray[np.uint8]:
    """A depth image as a picture, (H, W, 4) RGBA, from bright at `low` [m] to dark at `high`; nothing where invalid."""
    share = (depth - low) / max(high - low, 1e-6)
    at = np.linspace(0.0, 1.0, len(_DEPTH_COLORS))
    channels = [np.interp(share, at, values) for values in zip(*_DEPTH_COLORS, strict=True)]
    return np.stack([*channels, np.where(depth > 0.0, 255, 0)], axis=-1).round().astype(np.uint8)


# near is warm and bright, far is dark
_DEPTH_COLORS = ((253, 231, 120), (250, 170, 70), (225, 95, 85), (160, 50, 120), (85, 25, 120), (22, 14, 60))
