"""Logs like those of old robots, written by the embedded simulator, with the truth about them."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from threewe._core import LogSpec, log_lidar
from threewe.slam.carmen import write_carmen
from threewe.slam.log import Log
from threewe.slam.relations import Relations, seen_from, wrapped

NEIGHBOUR = 1.0  # [m] along the way between the places of a relation
AGAIN = 10.0  # [m] driven in between, for a place to count as met again ...
SAME_PLACE = 1.0  # [m] ... when it lies so near ...
SAME_HEADING = np.pi / 4  # [rad] ... and is seen from about the same side


def synthesize(name: str, folder: Path, seed: int = 0) -> tuple[Path, Path]:
    """Writes NAME.log and NAME.relations: a synthetic log with the noise of a seed."""
    log, truth = record(name, seed)
    folder.mkdir(parents=True, exist_ok=True)
    paths = folder / f"{Path(name).stem}.log", folder / f"{Path(name).stem}.relations"
    write_carmen(paths[0], log)
    true_relations(truth).write(paths[1])
    return paths


def record(name: str, seed: int = 0) -> tuple[Log, NDArray[np.float64]]:
    """A synthetic log, and the true trajectory (N, 4): time, x, y, heading."""
    log = Log(base_from_lidar=log_lidar())
    truth = []
    for view in LogSpec.load(name).drive(seed):
        log.add(view.time, view.scan, view.odometry)
        truth.append((view.time, *view.truth))
    return log, np.array(truth)


def true_relations(truth: NDArray[np.float64]) -> Relations:
    """Of a true trajectory: about each metre from neighbour to neighbour, and where a place is met again from there to
    the nearest pose of each earlier visit, as Kuemmerle et al. relate places whose scans overlap.
    """
    driven = np.concatenate([[0.0], np.linalg.norm(np.diff(truth[:, 1:3], axis=0), axis=1).cumsum()])
    stations = [0]
    for i in range(len(truth)):
        if driven[i] - driven[stations[-1]] >= NEIGHBOUR - 1e-9:
            stations.append(i)
    pairs = list(itertools.pairwise(stations))
    pairs += [(earlier, i) for i in stations for earlier in _visits(truth, driven, i)]
    first, second = np.array(pairs).T
    return Relations(truth[np.array(pairs), 0], seen_from(truth[first, 1:], truth[second, 1:]))


def _visits(truth: NDArray[np.float64], driven: NDArray[np.float64], i: int) -> list[int]:
    """The nearest pose of each earlier visit to the place of pose i."""
    earlier = np.flatnonzero(driven <= driven[i] - AGAIN)
    away = np.linalg.norm(truth[earlier, 1:3] - truth[i, 1:3], axis=1)
    turned = np.abs(wrapped(truth[earlier, 3] - truth[i, 3]))
    near = earlier[(away <= SAME_PLACE) & (turned <= SAME_HEADING)]
    visits = np.split(near, np.flatnonzero(np.diff(driven[near]) > AGAIN) + 1)
    return [int(v[np.linalg.norm(truth[v, 1:3] - truth[i, 1:3], axis=1).argmin()]) for v in visits if len(v)]
