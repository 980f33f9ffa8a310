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
