"""pytorch-mppi: path integral control of a holonomic base in the room of mppi_bench.cpp."""

from __future__ import annotations

import importlib.metadata
import math
import sys
from pathlib import Path

import torch
from pytorch_mppi import MPPI
from world import report

SAMPLES, STEPS, STEP = 2000, 56, 0.05  # [s]
CELL, REACH = 0.025, 4.0  # [m] of a field of costs, and how far it goes to each side
RADIUS, MARGIN, CLOSE = 0.13, 0.05, 0.15  # [m] of the robot, to keep free, and where being near costs
PATH_LEFT, PATH_BESIDE, CONTACT, NEAR = 3.0, 2.0, 60.0, 0.1  # as ours
TEMPERATURE = 0.03  # with 0.3, as ours, what it charges for steering stops it before the door
ARRIVED, PATIENCE = 0.1, 30.0  # [m], [s]
Tensor = torch.Tensor


def main() -> None:
    """One tick, as it is and with its dynamics and costs compiled by torch."""
    torch.set_num_threads(1)
    torch.manual_seed(1)
    points, path = read_room(Path(sys.argv[1]))
    costs = field_of(points, path)
    arrived, nearest = drive(controller(costs), points, path)
    name = f"pytorch-mppi {importlib.metadata.version('pytorch-mppi')}"
    what = "a disc; one look-up a step for obstacles and path together; limits of speed alone; Python, torch"
    row = {"kind": "control", "arrived": arrived, "nearest": nearest}
    time_ticks({**row, "who": name, "differs": what}, controller(costs))
    compiled = controller(costs)
    compiled.compile()
    time_ticks({**row, "who": f"{name}, compiled", "differs": "the same through torch.compile"}, compiled)


def time_ticks(row: dict[str, object], mppi: MPPI) -> None:
    """From one pose, with the plan of the tick before."""
    pose = torch.tensor([0.0, 0.02, 0.1])
    report(row, f"{SAMPLES}x{STEPS}", 1, lambda: mppi.command(pose))


def read_room(file: Path) -> tuple[Tensor, Tensor]:
    """Points of a scan and of a path, (N, 2) and (M, 2) [m]."""
    rows = [line.split() for line in file.read_text().splitlines()]
    points, path = ([[float(x), float(y)] for kind, x, y in rows if kind == wanted] for wanted in ("point", "path"))
    return torch.tensor(points), torch.tensor(path)


def field_of(points: Tensor, path: Tensor) -> Tensor:
    """What it costs to be in each cell: the path that is left, the distance beside it, and obstacles."""
    axis = torch.arange(-REACH, REACH, CELL) + 0.5 * CELL
    cells = torch.stack(torch.meshgrid(axis, axis, indexing="ij"), dim=-1).reshape(-1, 2)
    clear = torch.cdist(cells, points).min(dim=1).values - RADIUS
    starts, pieces = path[:-1], path[1:] - path[:-1]
    lengths = pieces.norm(dim=1)
    along = ((cells[:, None] - starts) * pieces).sum(-1) / lengths**2
    feet = starts + along.clamp(0.0, 1.0)[..., None] * pieces
    beside, nearest = (cells[:, None] - feet).norm(dim=-1).min(dim=1)
    driven = torch.cat([torch.zeros(1), lengths.cumsum(0)[:-1]])[nearest]
    left = lengths.sum() - driven - along.clamp(0.0, 1.0).gather(1, nearest[:, None])[:, 0] * lengths[nearest]
    close = NEAR * ((MARGIN + CLOSE - clear) / CLOSE).clamp(0.0, 1.0) + CONTACT * (clear < MARGIN)
    side = round(2.0 * REACH / CELL)
    return (0.25 * (PATH_LEFT * left + PATH_BESIDE * beside**2) + close).reshape(side, side)


def controller(costs: Tensor) -> MPPI:
    """With our noise and limits of speed."""
    flat, side = costs.reshape(-1), costs.shape[0]

    def dynamics(state: Tensor, command: Tensor) -> Tensor:
        vx, vy, omega = command.unbind(1)
        cos, sin = torch.cos(state[:, 2]), torch.sin(state[:, 2])
        moved = torch.stack([vx * cos - vy * sin, vx * sin + vy * cos, omega], dim=1)
        return state + STEP * moved

    def cost(state: Tensor, _: Tensor) -> Tensor:
        cells = ((state[:, :2] + REACH) / CELL).long().clamp(0, side - 1)
        return flat[cells[:, 0] * side + cells[:, 1]]

    noise = torch.diag(torch.tensor([0.15, 0.15, 0.5]) ** 2)
    most = torch.tensor([0.5, 0.5, 1.0])
    made = MPPI(dynamics, cost, 3, noise, SAMPLES, STEPS, lambda_=TEMPERATURE, u_min=-most, u_max=most)
    made.U = torch.zeros(STEPS, 3)
    return made


def drive(mppi: MPPI, points: Tensor, path: Tensor) -> tuple[float, float]:
    """Drives a base that does at once what is commanded: how long it takes [s], -1 if for ever, and how near its middle
    comes to a point [m].
    """
    pose, nearest = torch.zeros(3), math.inf
    for tick in range(round(PATIENCE / STEP)):
        vx, vy, omega = mppi.command(pose)
        cos, sin = torch.cos(pose[2]), torch.sin(pose[2])
        pose = pose + STEP * torch.stack([vx * cos - vy * sin, vx * sin + vy * cos, omega])
        nearest = min(nearest, float((points - pose[:2]).norm(dim=1).min()))
        if float((path[-1] - pose[:2]).norm()) < ARRIVED:
            return STEP * (tick + 1), nearest
    return -1.0, nearest


if __name__ == "__main__":
    main()
