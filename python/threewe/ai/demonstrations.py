"""Rows of LeRobot datasets as a policy learns from them: pictures, instructions, and the actions that follow."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import Kinematics
from threewe.ai.folder import ACTION, CAMERA, EMBEDDED, EMBEDDING, UNITS, image_input
from threewe.ai.naming import NUMBERS, kinematics_of
from threewe.data.export_lerobot import embeddings_of
from threewe.data.lerobot import Dataset
from threewe.data.recording import DISTURBED
from threewe.errors import ConfigError

PICTURE = image_input(CAMERA)
CAMERA_DELAY = 0.1  # [s] before a row, its picture was measured: transport 0.08 s, and half a picture's period
MOST_HEIGHT = 128  # [px] pictures are made smaller until they are no higher
HELD_OUT = 0.1  # of the episodes


@dataclass
class Demonstrations:
    """Rows of a dataset, one beside the other."""

    pictures: NDArray[np.uint8]
    """(rows, H, W, 3) RGB"""
    embeddings: NDArray[np.float32]
    """(rows, 64)"""
    actions: NDArray[np.float32]
    """(rows, chunk, numbers) [m/s, rad/s]"""
    wanted: NDArray[np.bool_]
    """(rows, chunk) actions of the teacher's: none once random commands have pushed the robot since the picture"""
    held_out: NDArray[np.bool_]
    """(rows,) of episodes that are not learnt from"""


@dataclass(frozen=True)
class Velocity:
    """A number of a dataset's actions."""

    column: int
    name: str
    """`vx`, `vy` or `omega`"""
    scale: float
    """how much of m/s or rad/s one unit is"""


def velocities_of(dataset: Dataset) -> list[Velocity]:
    """The numbers of its actions that its robot can drive by. Raises ConfigError for what cannot be learnt from."""
    for name in (PICTURE, ACTION):
        if name not in dataset.features:
            raise ConfigError(f"{dataset.root}: no '{name}'; there are {', '.join(sorted(dataset.own_features))}")
    if EMBEDDED in dataset.features and dataset.features[EMBEDDED].shape != (EMBEDDING,):
        raise ConfigError(
            f"{dataset.root}: {EMBEDDED} has shape {dataset.features[EMBEDDED].shape}; expected the {EMBEDDING} "
            "numbers of an instruction, or no such column: then they are computed from the tasks"
        )
    names = [str(name) for name in dataset.features[ACTION].names or []]
    ours = [NUMBERS[name][0] for name in names if name in NUMBERS]
    if not names or len(set(ours)) < len(names):
        raise ConfigError(
            f"{dataset.root}: action is ({', '.join(names)}); expected vx, vy, omega, or LeRobot's names for them, "
            "such as x.vel"
        )
    differential = kinematics_of(dataset.info.robot_type, ours) is Kinematics.differential
    found = [Velocity(i, *_in_ours(name)) for i, name in enumerate(names)]
    return [each for each in found if not (differential and each.name == "vy")]


def _in_ours(name: str) -> tuple[str, float]:
    ours, unit = NUMBERS[name]
    return ours, UNITS[ours][unit]


def demonstrations(datasets: Sequence[Dataset], chunk: int) -> Demonstrations:
    """All rows. The actions of a row are those from its picture's time on, and zero beyond the episode's end."""
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:  # decoding needs no interpreter
        parts = list(chain.from_iterable(pool.map(lambda dataset: _rows_of(dataset, chunk), datasets)))
    if not parts:
        raise ConfigError(f"{datasets[0].root}: no episode that succeeded")
    fields = [list(values) for values in zip(*parts, strict=True)]
    parts.clear()
    return Demonstrations(*map(_joined, fields))


def _joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    """All of a list, which is emptied: pictures take most of the memory, and need not be there twice."""
    joined = np.empty((sum(map(len, parts)), *parts[0].shape[1:]), parts[0].dtype)
    row = 0
    while parts:
        part = parts.pop(0)
        joined[row : row + len(part)] = part
        row += len(part)
    return joined


def _rows_of(dataset: Dataset, chunk: int) -> list[tuple[NDArray[Any], ...]]:
    """The fields of `Demonstrations`, of each episode that succeeded."""
    earlier = round(CAMERA_DELAY * dataset.fps)
    velocities = velocities_of(dataset)
    kept, scale = [each.column for each in velocities], np.array([each.scale for each in velocities], np.float32)
    every = max(2, round(1 / HELD_OUT))
    parts: list[tuple[NDArray[Any], ...]] = []
    for episode in dataset.episodes:
        columns = episode.columns()
        if "next.success" in columns and not columns["next.success"].any():
            continue
        video, action = episode.video(PICTURE), columns[ACTION].astype(np.float32)[:, kept] * scale
        rows = len(episode)
        pictures = np.stack([_smaller(video.image(row)) for row in range(rows)])
        actions = _ahead(np.concatenate([np.repeat(action[:1], earlier, 0), action]), rows, chunk)
        pushed = columns[DISTURBED].reshape(-1, 1) if DISTURBED in columns else np.zeros((rows, 1), np.bool_)
        pushed = np.concatenate([np.repeat(pushed[:1], earlier, 0), pushed])
        wanted = ~np.maximum.accumulate(_ahead(pushed, rows, chunk)[:, :, 0], axis=1)
        given = columns[EMBEDDED] if EMBEDDED in columns else embeddings_of(episode.frame_tasks(columns))
        held_out = np.full(rows, episode.index % every == every - 1)
        parts.append((pictures, given.astype(np.float32), actions, wanted, held_out))
    return parts


def _ahead(values: NDArray[Any], rows: int, chunk: int) -> NDArray[Any]:
    """(rows, chunk, numbers): of each row its own values and those that follow, zero beyond the end."""
    padded = np.concatenate([values, np.zeros((chunk, values.shape[1]), values.dtype)])
    return np.stack([padded[row : row + chunk] for row in range(rows)])


def _smaller(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The mean of n x n pixels each, n the least that makes it low enough."""
    height, width, _ = picture.shape
    n = next(n for n in range(1, height + 1) if height // n <= MOST_HEIGHT and height % n == width % n == 0)
    if n == 1:
        return picture
    means = picture.reshape(height // n, n, width // n, n, 3).mean((1, 3))
    return np.asarray(means.round(), np.uint8)
