"""A robot at work, drawn in the terminal: the map as it grows, the way ahead, and where the robot believes to be."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import groupby, pairwise
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray
from rich.color import Color
from rich.console import Console, ConsoleOptions, RenderResult
from rich.live import Live
from rich.segment import Segment
from rich.style import Style
from rich.text import Text

from threewe._core import OccupancyGrid, Pose2D, Progress
from threewe.robot import Robot

FRAMES_EVERY = 0.12  # [s] of wall time
MARGIN = 0.6  # [m] around what is known
ROOM_FOR_FIGURES = 5  # lines
OCCUPIED, FREE = 65, 25  # as ROS has it: at least, at most

# What a pixel shows; what comes later covers what comes before.
NOTHING, GROUND, TRAJECTORY, PATH, WALL, GOAL = range(6)
COLORS = {
    GROUND: Color.from_rgb(58, 68, 86),
    TRAJECTORY: Color.from_rgb(70, 120, 190),
    PATH: Color.from_rgb(232, 90, 150),
    WALL: Color.from_rgb(206, 214, 226),
    GOAL: Color.from_rgb(120, 220, 120),
}
ROBOT = Color.from_rgb(255, 160, 50)
INK = Color.from_rgb(20, 24, 32)
ARROWS = "→↗↑↖←↙↓↘"  # counter-clockwise from east


@dataclass
class Canvas:
    """Square pixels over a part of the map, two to a character; row 0 is the highest y."""

    left: float  # [m]
    top: float  # [m]
    pixel: float  # [m]
    pixels: NDArray[np.uint8]

    @classmethod
    def around(cls, low: NDArray[np.float64], high: NDArray[np.float64], columns: int, lines: int) -> Canvas:
        """One that holds the rectangle from `low` to `high` (2,) [m] and fits into so many characters."""
        size = np.maximum(high - low, 1.0)
        pixel = float(max(size[0] / columns, size[1] / (2 * lines)))
        width, height = (max(1, math.ceil(side / pixel - 1e-9)) for side in size)
        return cls(low[0], high[1], pixel, np.zeros((height + height % 2, width), np.uint8))

    def mark(self, points: NDArray[np.float64], what: int) -> None:
        """Shows something at places (N, 2) [m], where nothing more important is."""
        columns = np.floor((points[:, 0] - self.left) / self.pixel).astype(int)
        rows = np.floor((self.top - points[:, 1]) / self.pixel).astype(int)
        inside = (columns >= 0) & (columns < self.pixels.shape[1]) & (rows >= 0) & (rows < self.pixels.shape[0])
        at = rows[inside], columns[inside]
        self.pixels[at] = np.maximum(self.pixels[at], what)

    def line(self, points: NDArray[np.float64], what: int) -> None:
        """Shows a polyline (N, 2) [m]."""
        for a, b in pairwise(points):
            steps = max(2, math.ceil(float(np.hypot(*(b - a))) / self.pixel * 2))
            self.mark(a + np.linspace(0.0, 1.0, steps)[:, None] * (b - a), what)

    def rows(self, robot: Pose2D) -> Iterator[list[Segment]]:
        """Line by line, with the robot as an arrow."""
        at = int((self.top - robot.y) / self.pixel) // 2, int((robot.x - self.left) / self.pixel)
        arrow = ARROWS[round(robot.theta / (math.pi / 4.0)) % 8]
        for i, (upper, lower) in enumerate(zip(self.pixels[::2], self.pixels[1::2], strict=True)):
            cells = [half_blocks(int(a), int(b)) for a, b in zip(upper, lower, strict=True)]
            if i == at[0] and 0 <= at[1] < len(cells):
                cells[at[1]] = Segment(arrow, Style(color=INK, bgcolor=ROBOT, bold=True))
            yield [Segment(cell.text * len(list(same)), cell.style) for cell, same in groupby(cells)]


@cache
def half_blocks(upper: int, lower: int) -> Segment:
    """Two pixels, one above the other, as one character."""
    if upper == lower:
        return Segment("█" if upper else " ", Style(color=COLORS.get(upper)))
    if upper == NOTHING:
        return Segment("▄", Style(color=COLORS[lower]))
    return Segment("▀", Style(color=COLORS[upper], bgcolor=COLORS.get(lower)))


class LivePicture(ABC):
    """What is drawn anew in a terminal while a robot is at work; a console that is no terminal stays empty."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._drawn_at = -math.inf
        self._live = Live(console=console, auto_refresh=False, vertical_overflow="crop")

    def __enter__(self) -> Self:
        if self._console.is_terminal:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._console.is_terminal:
            self._live.stop()

    @abstractmethod
    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """What is seen now."""

    def draw(self, *, at_once: bool = False) -> None:
        """Draws what is now, unless it was drawn a moment ago."""
        if self._console.is_terminal and (at_once or time.monotonic() - self._drawn_at >= FRAMES_EVERY):
            self._drawn_at = time.monotonic()
            self._live.update(self, refresh=True)


class Dashboard(LivePicture):
    """What is to be seen of a motion: `async with Robot(...) as robot` first, then `with Dashboard(...) as look:` and
    `on_progress=look`. It observes; what the robot does stays the same, to the bit.

    Args:
        robot: connected.
        console: where to; one that is no terminal stays empty.
        task: what the robot is doing, in words.
        goal: where it drives to, (x, y) [m] in `map`, if anywhere.
    """

    def __init__(self, robot: Robot, console: Console, task: str, goal: tuple[float, float] | None = None) -> None:
        super().__init__(console)
        self._robot, self._task = robot, task
        self._goal = np.array([goal]) if goal else np.empty((0, 2))
        self._trail = [self._place()]
        self._progress: Progress | None = None

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.draw(at_once=True)
        super().__exit__(kind, error, traceback)

    def __call__(self, progress: Progress) -> None:
        """How far the motion is."""
        self._progress = progress
        self._trail.append(self._place())
        self.draw()

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        grid, path = self._robot.get_map(), self._robot.get_path()
        lines = max(4, options.size.height - ROOM_FOR_FIGURES)
        canvas = picture(grid, np.array(self._trail), path, self._goal, options.max_width, lines)
        for row in canvas.rows(self._robot.get_pose()):
            yield from row
            yield Segment.line()
        yield from self._figures(grid)

    def _place(self) -> tuple[float, float]:
        pose = self._robot.get_pose()
        return pose.x, pose.y

    def _figures(self, grid: OccupancyGrid) -> Iterator[Text]:
        known = float((grid.data >= 0).sum()) * grid.resolution**2
        yield Text.assemble((self._task, "bold"), f", for {self._robot.now:.0f} robot s; {known:.0f} m² known")
        if self._progress:
            velocity = self._robot.get_velocity()
            driven, left = self._progress.distance_driven, self._progress.distance_left
            yield Text(f"{driven:.1f} m driven, {left:.1f} m ahead, {math.hypot(velocity.vx, velocity.vy):.2f} m/s")


def picture(
    grid: OccupancyGrid,
    trajectory: NDArray[np.float64],
    path: NDArray[np.float64],
    goal: NDArray[np.float64],
    columns: int,
    lines: int,
) -> Canvas:
    """The map, the way that was driven, the one ahead, and the goal; all of it within so many characters."""
    rows, cols = np.nonzero(grid.data >= 0)
    cells = np.array(grid.origin) + (np.column_stack([cols, rows]) + 0.5) * grid.resolution
    seen = np.concatenate([cells, trajectory, goal])
    canvas = Canvas.around(seen.min(axis=0) - MARGIN, seen.max(axis=0) + MARGIN, columns, lines)
    values = grid.data[rows, cols]
    canvas.mark(cells[values <= FREE], GROUND)
    canvas.mark(cells[values >= OCCUPIED], WALL)
    canvas.line(trajectory, TRAJECTORY)
    canvas.line(path, PATH)
    canvas.mark(goal, GOAL)
    return canvas
