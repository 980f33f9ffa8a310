"""The obvious twin of exact occupancy: which cells of a map the shapes of an exported file reach into."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

DEEP = 1e-9  # [m], a wall that ends where a cell begins, but for rounding, does not reach into it


@dataclass
class Block:
    """A box (`size` is its edges) or a cylinder (radius, radius, height) that stands upright."""

    name: str
    kind: str
    position: tuple[float, float, float]
    theta: float
    size: tuple[float, float, float]

    def is_cut_at(self, z: float) -> bool:
        return abs(z - self.position[2]) < 0.5 * self.size[2]


@dataclass
class Frame:
    """Where the cells of a map are."""

    origin: tuple[float, float]
    resolution: float
    width: int
    height: int


def read_map(folder: Path) -> tuple[Frame, np.ndarray]:
    """The ROS map in a folder: where it is, and its picture with the lowest y first."""
    settings = dict(line.split(": ", 1) for line in (folder / "map.yaml").read_text().splitlines())
    data = (folder / settings["image"]).read_bytes()
    magic, comment, size, depth, pixels = data.split(b"\n", 4)
    assert (magic, depth) == (b"P5", b"255")
    assert comment.startswith(b"#")
    width, height = map(int, size.split())
    x, y, _ = (float(number) for number in settings["origin"].strip("[]").split(","))
    picture = np.frombuffer(pixels, np.uint8).reshape(height, width)[::-1]
    return Frame((x, y), float(settings["resolution"]), width, height), picture


def occupied(blocks: list[Block], frame: Frame, z: float) -> np.ndarray:
    """Whether each cell overlaps what the plane at a height cuts."""
    cells = np.zeros((frame.height, frame.width), bool)
    for block in blocks:
        if block.is_cut_at(z):
            mark(cells, block, frame)
    return cells


def mark(cells: np.ndarray, block: Block, frame: Frame) -> None:
    half = 0.5 * frame.resolution
    reach = 0.5 * float(np.hypot(*block.size[:2])) if block.kind == "box" else block.size[0]
    low = [int((block.position[i] - reach - frame.origin[i]) / frame.resolution) - 1 for i in (0, 1)]
    high = [int((block.position[i] + reach - frame.origin[i]) / frame.resolution) + 2 for i in (0, 1)]
    columns = np.arange(max(low[0], 0), min(high[0], frame.width))
    rows = np.arange(max(low[1], 0), min(high[1], frame.height))
    x = frame.origin[0] + (columns[None, :] + 0.5) * frame.resolution - block.position[0]
    y = frame.origin[1] + (rows[:, None] + 0.5) * frame.resolution - block.position[1]
    if block.kind == "cylinder":
        near = np.hypot(np.maximum(np.abs(x) - half, 0), np.maximum(np.abs(y) - half, 0)) < block.size[0] - DEEP
    else:
        c, s = np.cos(block.theta), np.sin(block.theta)
        length, width = 0.5 * block.size[0], 0.5 * block.size[1]
        wide = half * (abs(c) + abs(s))  # half of a cell, as seen along the box
        near = (
            (length + wide - np.abs(c * x + s * y) > DEEP)
            & (width + wide - np.abs(-s * x + c * y) > DEEP)
            & (half + length * abs(c) + width * abs(s) - np.abs(x + 0 * y) > DEEP)
            & (half + length * abs(s) + width * abs(c) - np.abs(y + 0 * x) > DEEP)
        )
    cells[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1] |= near
