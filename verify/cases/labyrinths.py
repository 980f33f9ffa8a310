"""Places made to mislead, around the origin: mazes, spirals, rings of like corridors, many narrow doors in turn."""

import asyncio
import math
import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from threewe import Pose2D, RobotProfile, Scene, SceneTables

from verify.cases.generated import drive_to, saved

PITCH = 1.6  # [m] from cell to cell of a maze, and from turn to turn of a spiral
THICK = 0.1  # [m] walls
DOORS = 7
SPARE = 0.10  # [m] by which a narrow door is wider than the robot
Point = tuple[float, float]
Wall = tuple[Point, Point]


@dataclass(frozen=True)
class Place:
    """Walls around the origin, and where to go."""

    walls: list[Wall]
    goal: Point

    def text(self, name: str) -> str:
        """As a scene."""
        lines = [f"name: {name}", "description: made to mislead", "starts: [[0.0, 0.0, 0.0]]", "walls:"]
        for (ax, ay), (bx, by) in self.walls:
            lines.append(f"  - {{a: [{ax:.3f}, {ay:.3f}], b: [{bx:.3f}, {by:.3f}], thickness: {THICK}}}")
        return "\n".join([*lines, ""])


def maze(draw: random.Random, _width: float) -> Place:
    """A spanning tree of cells, drawn by depth-first search; to the cell that is farthest along its corridors."""
    columns, rows = draw.randint(5, 9), draw.randint(4, 7)
    open_sides: set[frozenset[tuple[int, int]]] = set()
    depth = {(0, 0): 0}
    stack = [(0, 0)]
    while stack:
        x, y = stack[-1]
        around = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)]
        fresh = [cell for cell in around if cell not in depth and 0 <= cell[0] < columns and 0 <= cell[1] < rows]
        if not fresh:
            stack.pop()
            continue
        cell = draw.choice(fresh)
        depth[cell] = depth[x, y] + 1
        open_sides.add(frozenset(((x, y), cell)))
        stack.append(cell)
    closed = [
        side
        for x in range(-1, columns)
        for y in range(-1, rows)
        for side in (((x, y), (x + 1, y)), ((x, y), (x, y + 1)))
        if frozenset(side) not in open_sides and any(cell in depth for cell in side)
    ]
    end = max(depth, key=lambda cell: depth[cell])
    return Place([between(*side) for side in closed], (PITCH * end[0], PITCH * end[1]))


def between(a: tuple[int, int], b: tuple[int, int]) -> Wall:
    """The wall between two neighbouring cells."""
    x, y = PITCH * 0.5 * (a[0] + b[0]), PITCH * 0.5 * (a[1] + b[1])
    half = 0.5 * PITCH
    return ((x, y - half), (x, y + half)) if a[1] == b[1] else ((x - half, y), (x + half, y))


def spiral(draw: random.Random, _width: float) -> Place:
    """From the outside of a square spiral, counter-clockwise, to its middle."""
    turns = draw.randint(3, 5)
    lengths = [2 * turns, *(length for length in range(2 * turns, 1, -1) for _ in range(2))]
    x, y = -0.5 * PITCH, -0.5 * PITCH
    walls = [((x, y), (x, y + PITCH))]
    ahead, left = (PITCH, 0.0), (0.0, PITCH)
    for length in lengths:
        end = x + length * ahead[0], y + length * ahead[1]
        walls.append(((x, y), end))
        last, (x, y) = (ahead, left), end
        ahead, left = left, (-ahead[0], -ahead[1])
    goal = x + 0.5 * (last[1][0] - last[0][0]), y + 0.5 * (last[1][1] - last[0][1])
    return Place(walls, goal)


def ring(draw: random.Random, _width: float) -> Place:
    """Corridors alike around a square block; to the opposite corner."""
    side, width = draw.uniform(10.0, 18.0), draw.uniform(1.4, 2.2)
    inner = box((0.5 * width, 0.5 * width), (side - 0.5 * width, side - 0.5 * width))
    outer = box((-0.5 * width, -0.5 * width), (side + 0.5 * width, side + 0.5 * width))
    return Place([*inner, *outer], (side, side))


def doors(draw: random.Random, width: float) -> Place:
    """A corridor with seven narrow doors, for a robot of that width."""
    half, step = draw.uniform(0.9, 1.3), draw.uniform(1.6, 2.4)
    gap = width + SPARE
    end = step * (DOORS + 1)
    walls = box((-1.0, -half), (end, half))
    for k in range(1, DOORS + 1):
        middle = draw.uniform(-half + 0.5, half - 0.5)
        walls += [
            ((k * step, -half), (k * step, middle - 0.5 * gap)),
            ((k * step, middle + 0.5 * gap), (k * step, half)),
        ]
    return Place(walls, (end - 0.8, 0.0))


def box(low: Point, high: Point) -> list[Wall]:
    """The four sides of a rectangle."""
    corners = [low, (high[0], low[1]), high, (low[0], high[1])]
    return list(zip(corners, [*corners[1:], corners[0]], strict=True))


PLACES: dict[str, Callable[[random.Random, float], Place]] = {
    "maze": maze,
    "spiral": spiral,
    "ring": ring,
    "doors": doors,
}


def mislead(seed: int, place: str, hardware: str) -> dict[str, Any]:
    """A drive from the origin, in any heading, to the end of such a place."""
    draw = random.Random(seed)
    profile = RobotProfile.load(hardware)
    made = PLACES[place](draw, width_of(profile.footprint))
    start = Pose2D(0.0, 0.0, draw.uniform(-math.pi, math.pi))
    with saved(made.text(f"{place}_{seed}")) as scene:
        geodesic = SceneTables(Scene.load(scene), profile).geodesic((0.0, 0.0), made.goal)
        case = asyncio.run(drive_to(scene, hardware, seed, start, made.goal, geodesic))
    driving = geodesic / profile.operating_limits.linear
    return case | {"place": place, "seconds_a_door": (case["seconds"] - driving) / DOORS}


def width_of(corners: Iterable[Point]) -> float:
    """[m] from side to side."""
    sides = [y for _, y in corners]
    return max(sides) - min(sides)
