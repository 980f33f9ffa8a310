"""ir-sim: its planners for grids, in a window of the place: through all of it they would take hours."""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path

os.environ.setdefault("MPLBACKEND", "Agg")
import irsim
import numpy as np
from course import Course, Point, report_plans
from irsim.lib.path_planners import AStarPlanner, JPSPlanner
from irsim.world.map import Map

QUERIES = 3  # they take long


def main() -> None:
    """Plans the first queries with each."""
    course = Course.read(Path(sys.argv[1]))
    free = np.frombuffer(course.free, np.uint8).reshape(course.height, course.width)
    width, height = course.width * course.resolution, course.height * course.resolution
    grid = Map(width, height, course.resolution, grid=np.where(free.T == 0, 100.0, 0.0))
    for planner in (AStarPlanner(grid), JPSPlanner(grid)):

        def plan(start: Point, goal: Point, planner: AStarPlanner | JPSPlanner = planner) -> list[Point]:
            with contextlib.redirect_stdout(None):
                found = planner.planning(np.array(start), np.array(goal), show_animation=False)
            return [] if found is None else list(zip(*found.tolist(), strict=True))[::-1]

        row = {
            "who": f"ir-sim {irsim.__version__}, {type(planner).__name__}",
            "differs": "8-connected corners of cells, all four around them free; Python",
        }
        report_plans(row, course, QUERIES, plan)


if __name__ == "__main__":
    main()
