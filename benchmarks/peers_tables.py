"""What was measured, as tables: how many times as long each takes as ours, where they do the same work."""

from __future__ import annotations

import statistics
import textwrap
from typing import Any

from world import BEAMS, PERIOD, PICTURES, SUBSTEPS

REFERENCES = (  # that ratios are to
    "ours",
    "ours, 1,024 at once, 5 ticks",
    "ours, 1,024 at once, 10 ticks",
    "ours, one alone, 5 ticks",
)
PLANNED = ("ours", "ours, the first plan")  # the same, of plans
SHORTEST = "ours, the shortest way"
GRAZED = 0.1  # [m] of a way through exact corners of blocked cells, which are neither in nor out
Result = dict[str, Any]
Rows = dict[str, dict[str, Result]]  # by who and size


def print_tables(results: list[Result]) -> None:
    """Those of which there is anything."""
    kinds = {result["kind"] for result in results}
    if "scan" in kinds:
        print_simulators(results)
    if "plan" in kinds:
        print_plans(results, "campus", "Plans of 70 to 80 m in 200 m x 200 m of furnished buildings")
        print_plans(results, "window", "Plans of 8 to 12 m in a window of 16 m x 16 m of the same")
    if "control" in kinds:
        print("\nControl [us]: a plan of path integral control through a room and a door, a holonomic base, no people;")
        print("robots drive with 512 samples of 56 steps, and a plan in each fifth tick")
        print_table(results, "control", {"512x56": "512 x 56", "2000x56": "2,000 x 56"}, 1e6)
    if "slam" in kinds:
        print_maps(results)


def print_simulators(results: list[Result]) -> None:
    """Scans, steps and pictures."""
    lidar, camera = "range 12 m, 0.135 m above the floor", "colour and depth, 0.12 m above the floor, 1.2 rad wide"
    print(f"\nLidar [ns a ray]: all walls and furniture of office_v2, {lidar}, without noise")
    print_table(results, "scan", {str(beams): f"{beams} beams" for beams in BEAMS}, 1e9)
    print(
        f"\nSteps [us]: {PERIOD} s in {SUBSTEPS} steps of physics in office_v2, then a scan of {lidar}, without noise"
    )
    print(
        "x: as many times as long as ours take: 1,024 at once with 5 ticks of 20 ms a step / with 10 / one alone with 5"
    )
    print_table(results, "step", {"0": "no lidar", **{str(beams): f"{beams} beams" for beams in BEAMS}}, 1e6)
    print(f"\nPictures [us]: {camera}, of office_v2, drawn by one CPU")
    print_table(results, "picture", {f"{width}x{height}": f"{width}x{height}" for width, height in PICTURES}, 1e6)


def print_table(results: list[Result], kind: str, sizes: dict[str, str], scale: float) -> None:
    """A line of figures for each competitor, and what is different about it."""
    rows = by_who(results, kind)
    ours = [row for who, row in rows.items() if who in REFERENCES]
    print(f"{'':31}" + "".join(f"{title:>10}{'x':>20}" for title in sizes.values()))
    for who, row in rows.items():
        cells = (cell(row.get(size), [reference[size] for reference in ours], scale) for size in sizes)
        print_row(f"{who:31}{''.join(cells)}", describe(row))


def print_plans(results: list[Result], course: str, title: str) -> None:
    """Times, and what the ways are worth, beside ours for the same queries."""
    plans: dict[str, dict[int, Result]] = {}
    for result in results:
        if result["kind"] == "plan" and result["size"] == course:
            plans.setdefault(result["who"], {})[result["query"]] = result
    if not plans:
        return
    print(f"\n{title}, in cells of 5 cm, obstacles grown by the robot's radius of 0.13 m beforehand")
    print("x: as many times as long as ours with its tables kept / without any; length: beside our shortest ways;")
    print("cost, of length and nearness to obstacles, which only ours looks at: beside ours")
    print(f"{'':31}{'plans':>6}{'solved':>8}{'median [ms]':>13}{'p90':>9}{'x':>17}{'length':>8}{'cost':>7}")
    for who, found in plans.items():
        print_row(f"{who:31}{plan_cells(found, plans)}", plan_words(found))


def plan_cells(found: dict[int, Result], plans: dict[str, dict[int, Result]]) -> str:
    """Figures of one planner."""
    milliseconds = [1e3 * plan["seconds"] for plan in found.values()]
    solved = {query: plan for query, plan in found.items() if plan["length"] > 0.0}
    ratios = []
    if not next(iter(found.values()))["who"].startswith("ours"):
        for who in PLANNED:
            same = [1e3 * plans[who][query]["seconds"] for query in found]
            ratios.append(rounded(statistics.median(milliseconds) / statistics.median(same)))
    line = f"{len(found):>6}{len(solved) / len(found):>8.0%}{rounded(statistics.median(milliseconds)):>13}"
    line += f"{rounded(quantile(milliseconds, 0.9)):>9}{' / '.join(ratios):>17}"
    if not solved:
        return line
    length = statistics.fmean(plan["length"] / plans[SHORTEST][query]["length"] for query, plan in solved.items())
    cost = statistics.fmean(plan["cost"] / plans[PLANNED[0]][query]["cost"] for query, plan in solved.items())
    return f"{line}{length:>8.3f}{cost:>7.2f}"


def plan_words(found: dict[int, Result]) -> str:
    """What is different about a planner."""
    blocked = max(plan["blocked"] for plan in found.values())
    cuts = f"; cuts corners: up to {blocked:.2f} m of a way is blocked" if blocked > GRAZED else ""
    return f"{next(iter(found.values()))['differs']}{cuts}"


def quantile(values: list[float], share: float) -> float:
    """The value that so large a share of them does not exceed."""
    return sorted(values)[int(share * (len(values) - 1))]


def print_maps(results: list[Result]) -> None:
    """The error of Kuemmerle et al. 2009, and how much faster than it was recorded a log is mapped."""
    rows = by_who(results, "slam")
    logs = list(dict.fromkeys(result["size"] for result in results if result["kind"] == "slam"))
    print("\nMaps of logs by `threewe slam synth`, 180 beams over half a turn: error by their relations, and data")
    print("seconds per second; x: as many times as long as ours")
    print(f"{'':31}" + "".join(f"{log + ' [m]':>22}{'[deg]':>16}{'data s/s':>10}{'x':>6}" for log in logs))
    for who, row in rows.items():
        cells = (map_cells(row.get(log), rows["ours"][log]) for log in logs)
        print_row(f"{who:31}{''.join(cells)}", describe(row))


def map_cells(result: Result | None, ours: Result) -> str:
    """Figures of one mapper and log."""
    if result is None:
        return f"{'':54}"
    (metres, metres_std), (degrees, degrees_std) = result["translation"], result["rotation"]
    seconds = median(result)
    ratio = "" if result["who"] == "ours" else rounded(seconds / median(ours))
    error = f"{metres:.4f} +- {metres_std:.4f}"
    turned = f"{degrees:.2f} +- {degrees_std:.2f}"
    return f"{error:>22}{turned:>16}{rounded(result['data_seconds'] / seconds):>10}{ratio:>6}"


def by_who(results: list[Result], kind: str) -> Rows:
    """Results of one kind."""
    rows: Rows = {}
    for result in results:
        if result["kind"] == kind:
            rows.setdefault(result["who"], {})[result["size"]] = result
    return rows


def print_row(figures: str, words: str) -> None:
    """A line of figures, and what is different about them."""
    print(figures.rstrip())
    print(textwrap.indent(textwrap.fill(words, 96), "    "))


def cell(result: Result | None, references: list[Result], scale: float) -> str:
    """A figure, and its ratios to ours."""
    if result is None:
        return f"{'':30}"
    seconds = median(result)
    ratios = [seconds / median(ours) for ours in references if comparable(result, ours)]
    return f"{rounded(scale * seconds):>10}{' / '.join(map(rounded, ratios)):>20}"


def median(result: Result) -> float:
    """[s] of its timings."""
    return float(statistics.median(result["seconds"]))


def rounded(value: float) -> str:
    """To two or three digits that count."""
    return f"{value:,.{0 if value >= 10 else 1 if value >= 1 else 3}f}"


def comparable(result: Result, ours: Result) -> bool:
    """Whether a ratio means something: the same scene, size and range, and ours takes no fewer steps of physics. Where
    the steps themselves are more than ours, or rays are cast in 3D, the row says "different work".
    """
    same = all(result.get(fact) == ours.get(fact) for fact in ("scene", "size", "range"))
    return same and result.get("substeps", 0) <= ours.get("substeps", 0) and not result["who"].startswith("ours")


def describe(row: dict[str, Result]) -> str:
    """What is different about it."""
    first = next(iter(row.values()))
    words = [f"different work: {first['work']}"] if "work" in first else []
    words.append(first["differs"])
    if "substeps" in first:
        time = f" in {first['period']:.2g} s" if "period" in first else ""
        words.append(f"{first['substeps']} step{'s' * (first['substeps'] > 1)} of physics{time}")
    if "arrived" in first:
        drive = f"arrives in {first['arrived']:.1f} s" if first["arrived"] > 0.0 else "does not arrive"
        words.append(f"{drive}, its middle {first['nearest']:.2f} m from an obstacle at the nearest")
    ranges = [f"{result['mean_range']:.2f}" for result in row.values() if "mean_range" in result]
    if ranges:
        words.append(f"mean range {' and '.join(ranges)} m")
    return "; ".join(words)
