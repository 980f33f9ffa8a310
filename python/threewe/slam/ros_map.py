"""Maps as ROS keeps them: a picture, and a file that says where it lies."""

from __future__ import annotations

import os

from threewe import _core
from threewe._core import OccupancyGrid


def load_map(path: str | os.PathLike[str]) -> OccupancyGrid:
    """Reads `map.yaml` and the PGM picture that it names, in ROS's `trinary` mode.

    Raises ConfigError naming the file and the field that is wrong.
    """
    return _core.load_map(os.fspath(path))


def save_map(grid: OccupancyGrid, path: str | os.PathLike[str]) -> None:
    """Writes `path`, which ends in .yaml, and the image next to it, as nav2's map saver does.

    Raises ConfigError where that cannot be done.
    """
    _core.save_map(grid, os.fspath(path))
