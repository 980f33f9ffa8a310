"""Map around a robot as text: what it has mapped, what its lidar measures now, and where it drove."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rich.console import Console, ConsoleOptions, RenderResult
from rich.segment import Segment

from threewe._core import OccupancyGrid
from threewe.robot import Robot
from threewe.teleop.obstacles import obstacle_points
from threewe.terminal import FREE, GROUND, OCCUPIED, TRAJECTORY, WALL, Canvas

SIGHT = 4.0
"""[m] that it shows to each side, at least."""


class LocalMap:
    """A picture of characters, north up, with the robot in its middle.

    Args:
        robot: connected, with a lidar.
        trajectory: (x, y) [m] in `map`, of where it drove.
        columns: characters.
        lines: characters; each shows two pixels, one above the other.
    """

    def __init__(self, robot: Robot, trajectory: Sequence[tuple[float, float]], columns: int, lines: int) -> None:
        self._robot, self._trajectory, self._columns, self._lines = robot, trajectory, columns, lines

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        pose = self._robot.get_pose()
        pixel = 2.0 * SIGHT / min(self._columns, 2 * self._lines)
        half_width, half_height = 0.5 * self._columns * pixel, self._lines * pixel
        pixels = np.zeros((2 * self._lines, self._columns), np.uint8)
        canvas = Canvas(pose.x - half_width, pose.y + half_height, pixel, pixels)
        cells, values = cells_near(self._robot.get_map(), pose.x, pose.y, max(half_width, half_height))
        canvas.mark(cells[values <= FREE], GROUND)
        canvas.mark(cells[values >= OCCUPIED], WALL)
        canvas.mark(np.array(self._trajectory).reshape(-1, 2), TRAJECTORY)
        cosine, sine = math.cos(pose.theta), math.sin(pose.theta)
        map_from_base = np.array([[cosine, -sine], [sine, cosine]])
        canvas.mark(obstacle_points(self._robot) @ map_from_base.T + (pose.x, pose.y), WALL)
        for segments in canvas.rows(pose):
            yield from segments
            yield Segment.line()


def cells_near(grid: OccupancyGrid, x: float, y: float, reach: float) -> tuple[NDArray[np.float64], NDArray[np.int8]]:
    """Centres (N, 2) [m], values (N,) of known cells within `reach` [m] of a place along each axis, or hardly more.

    It looks at no other part of the grid: maps become large.
    """
    cells = math.ceil(reach / grid.resolution) + 1
    column = math.floor((x - grid.origin[0]) / grid.resolution)
    row = math.floor((y - grid.origin[1]) / grid.resolution)
    left, bottom = max(0, column - cells), max(0, row - cells)
    data = np.asarray(grid.data)[bottom : max(0, row + cells + 1), left : max(0, column + cells + 1)]
    rows, columns = np.nonzero(data >= 0)
    centres = np.array(grid.origin) + (np.column_stack([left + columns, bottom + rows]) + 0.5) * grid.resolution
    return centres, data[rows, columns]
