"""What planners in Python are given, and how they are timed: course.hpp says the same in C++."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

Point = tuple[float, float]  # [m]


@dataclass(frozen=True)
class Course:
    """Cells, of which those that no path may touch are blocked: obstacles have the robot's radius already. Cell (0, 0)
    has its lower left corner at (0, 0) m.
    """

    name: str
    resolution: float  # [m]
    width: int  # [cells]
    height: int
    free: bytes  # row by row; 0 is blocked
    queries: list[tuple[Point, Point]]

    @staticmethod
    def read(path: Path) -> Course:
        """What our_planning.cpp has written."""
        queries: list[tuple[Point, Point]] = []
        for line in path.read_text().splitlines():
            word, *words = line.split()
            if word == "course":
                name, resolution, map_name = words
            elif word == "query":
                x, y, to_x, to_y = map(float, words)
                queries.append(((x, y), (to_x, to_y)))
        header, free = (path.parent / map_name).read_bytes().split(b"\n", 1)
        width, height = (int(number) for number in header.split()[1:3])
        return Course(name, float(resolution), width, height, free, queries)


def report_plans(
    row: dict[str, object], course: Course, queries: int, plan: Callable[[Point, Point], Sequence[Point]]
) -> None:
    """Prints the CPU seconds of each query, and the way that was found; none is no way."""
    for i, (start, goal) in enumerate(course.queries[:queries]):
        begin = time.process_time()
        way = plan(start, goal)
        seconds = time.process_time() - begin
        facts = {"kind": "plan", **row, "size": course.name, "query": i, "seconds": seconds}
        print(json.dumps({**facts, "way": list(way)}), flush=True)
