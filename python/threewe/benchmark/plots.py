"""Plots of a report as SVG, and scenes from above as polygons."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from typing import Any

from threewe._core import Pose2D, Scene
from threewe.benchmark.statistics import mean

Polygon = list[tuple[float, float]]
WIDTH, LEFT, RIGHT, TOP, ROW = 440, 112, 56, 44, 24  # of a plot, in its own units
INK, GRID = "#2f6fde", "#dfe3ea"
TICKS = (0, 0.25, 0.5, 0.75, 1)


def interval_plot(title: str, figures: Sequence[tuple[str, dict[str, Any]]]) -> str:
    """A row for each figure from 0 to 1: its interval as a line, its value as a dot and in digits."""
    height = TOP + ROW * len(figures)
    parts = []
    for i, (name, figure) in enumerate(figures):
        y = TOP + ROW * i + 8
        low, value, high = (_across(figure[key]) for key in ("low", "value", "high"))
        weight = ' style="font-weight:600"' if i == 0 else ""
        parts.append(
            f'<text x="{LEFT - 10}" y="{y + 4}" text-anchor="end"{weight}>{html.escape(name)}</text>'
            f'<line x1="{low:.1f}" x2="{high:.1f}" y1="{y}" y2="{y}" stroke="{INK}" stroke-width="5" opacity="0.35"/>'
            f'<circle cx="{value:.1f}" cy="{y}" r="5" fill="{INK}"/>'
            f'<text x="{WIDTH}" y="{y + 4}" text-anchor="end"{weight}>{figure["value"]:.2f}</text>'
        )
    said = "; ".join(f"{name} {figure['value']:.2f}" for name, figure in figures)
    return _plot(title, said, height, _grid(height) + "".join(parts))


def share_plot(title: str, curves: Sequence[Sequence[float]]) -> str:
    """Shares over time, each curve from 0 at time 0 in equal steps; their mean is drawn thick."""
    height = 200
    bottom = height - 24
    middle = [mean(column) for column in zip(*curves, strict=True)]

    def up(share: float) -> float:
        return bottom - (bottom - TOP) * share

    def path(curve: Sequence[float], style: str) -> str:
        points = " ".join(
            f"{_across(i / len(curve)):.1f},{bottom - (bottom - TOP) * value:.1f}"
            for i, value in enumerate([0.0, *curve])
        )
        return f'<polyline points="{points}" fill="none" stroke="{INK}" {style}/>'

    levels = "".join(
        f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}" stroke="{GRID}"/>'
        f'<text class="tick" x="{LEFT - 10}" y="{y + 4:.1f}" text-anchor="end">{share:g}</text>'
        for share in TICKS
        for y in (up(share),)
    )
    times = "".join(
        f'<text class="tick" x="{_across(share):.1f}" y="{height - 6}" text-anchor="middle">{share:.0%}</text>'
        for share in TICKS
    )
    thin = "".join(path(curve, 'stroke-width="1" opacity="0.35"') for curve in curves)
    value = f'<text x="{WIDTH}" y="{up(middle[-1]) + 4:.1f}" text-anchor="end">{middle[-1]:.2f}</text>'
    drawn = levels + times + thin + path(middle, 'stroke-width="3"') + value
    return _plot(title, f"{middle[-1]:.2f} in the end", height, drawn)


def _plot(title: str, said: str, height: int, drawn: str) -> str:
    label = html.escape(f"{title}: {said}", quote=True)
    head = f'<text class="title" x="{LEFT}" y="14">{html.escape(title)}</text>'
    return f'<svg viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{label}">{head}{drawn}</svg>'


def _grid(height: int) -> str:
    return "".join(
        f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{TOP - 8}" y2="{height - 4}" stroke="{GRID}"/>'
        f'<text class="tick" x="{x:.1f}" y="{TOP - 12}" text-anchor="middle">{share:g}</text>'
        for share in TICKS
        for x in (_across(share),)
    )


def _across(share: float) -> float:
    return LEFT + (WIDTH - RIGHT - LEFT) * share


def from_above(scene: Scene) -> dict[str, Any]:
    """Walls and furniture as polygons [m], in centimetres."""
    walls = [wall_outline(wall.a, wall.b, wall.thickness) for wall in scene.walls]
    furniture = [
        [_placed(thing.pose, corner) for corner in prism.outline()]
        for thing in scene.objects
        for prism in thing.prisms
        if prism.z_min < 2.0
    ]
    rooms = [
        {"name": room.name.replace("_", " "), "min": list(room.min), "max": list(room.max)} for room in scene.rooms
    ]
    drawn = {"walls": rounded(walls), "furniture": rounded(furniture)}
    return {"min": list(scene.min), "max": list(scene.max), "rooms": rooms, **drawn}


def wall_outline(a: tuple[float, float], b: tuple[float, float], thickness: float) -> Polygon:
    """The corners of a straight wall."""
    length = math.dist(a, b) or 1.0
    x, y = -(b[1] - a[1]) / length * thickness / 2, (b[0] - a[0]) / length * thickness / 2
    return [(a[0] + x, a[1] + y), (b[0] + x, b[1] + y), (b[0] - x, b[1] - y), (a[0] - x, a[1] - y)]


def rounded(polygons: Sequence[Polygon]) -> list[list[list[float]]]:
    """To centimetres."""
    return [[[round(x, 2), round(y, 2)] for x, y in polygon] for polygon in polygons]


def _placed(pose: Pose2D, corner: tuple[float, float]) -> tuple[float, float]:
    point = pose * Pose2D(corner[0], corner[1], 0.0)
    return point.x, point.y
