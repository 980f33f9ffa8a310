"""Compares what a dataset notes of its episodes with what is in them: order, times, statistics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from threewe.data.lerobot.features import DEFAULT_FEATURES
from threewe.data.lerobot.info import Info
from threewe.data.lerobot.stats import Stats, aggregate, column_stats

if TYPE_CHECKING:
    from threewe.data.lerobot.dataset import Episode

TIME_TOLERANCE = 1e-4
"""[s] LeRobot's own between a row and its frame."""
NUMBERS_TOLERANCE = 1e-3
"""Of a column's range: writers add in single precision, and count quantiles in 5000 bins."""
IMAGE_TOLERANCES = {"mean": 0.06, "std": 0.12, "q10": 0.2, "q50": 0.2, "q90": 0.2}
"""Of statistics that LeRobot took before the images were compressed, in single precision; a wrong video is far off."""


def check_order(columns: Mapping[str, NDArray[Any]], episode: Episode, fps: int) -> Iterator[tuple[int, str]]:
    """Rows of an episode whose numbers or time are not those of their place, the first of each column."""
    counted = np.arange(episode.length)
    wanted = {
        "frame_index": counted,
        "index": counted + episode.row.start,
        "episode_index": np.full(episode.length, episode.index),
    }
    for name, right in wanted.items():
        wrong = np.flatnonzero(columns[name] != right)
        if len(wrong):
            yield int(wrong[0]), f"{name} {columns[name][wrong[0]]}; it must be {right[wrong[0]]}{more(wrong)}"
    times = counted / fps
    wrong = np.flatnonzero(np.abs(columns["timestamp"].astype(float) - times) > TIME_TOLERANCE + times * 1e-6)
    if len(wrong):
        i = int(wrong[0])
        found, right_one = columns["timestamp"][i], times[i]
        yield i, f"timestamp {found:.6g} s; at {fps} frames a second it must be {right_one:.6g}{more(wrong)}"


def more(wrong: NDArray[Any]) -> str:
    """How many rows beside the first."""
    return f" (and {len(wrong) - 1} more rows)" if len(wrong) > 1 else ""


def check_column_stats(columns: Mapping[str, NDArray[Any]], noted: Mapping[str, Stats], info: Info) -> Iterator[str]:
    """Statistics of columns that differ from those computed anew."""
    for name, values in columns.items():
        if info.features[name].dtype == "string":
            continue
        if name not in noted:
            yield f"stats/{name} missing"
            continue
        right = column_stats(values)
        keys = ("min", "max", "count") if name in DEFAULT_FEATURES else tuple(noted[name])
        for key in keys:
            yield from compare(f"stats/{name}/{key}", noted[name][key], right[key], margin(right))


def margin(stats: Stats) -> NDArray[Any]:
    """How far a statistic may be off."""
    spread = np.abs(stats["max"] - stats["min"])
    size = np.maximum(np.abs(stats["max"]), np.abs(stats["min"]))
    return np.asarray(NUMBERS_TOLERANCE * spread + 1e-5 * size + 1e-6)


def check_image_stats(camera: str, right: Stats, noted: Stats | None, *, depth: bool) -> Iterator[str]:
    """Statistics of images that are far from those of the frames as decoded."""
    if noted is None:
        yield f"stats/{camera} missing"
        return
    channels = len(right["mean"])
    yield from compare(f"stats/{camera}/count", noted["count"], right["count"], np.zeros(1))
    scale = max(float(right["max"].max()), 1.0) if depth else 1.0
    for key, tolerance in IMAGE_TOLERANCES.items():
        if key not in noted:
            continue
        if noted[key].shape != (channels, 1, 1):
            yield f"stats/{camera}/{key} has shape {noted[key].shape}; it must be ({channels}, 1, 1)"
        else:
            yield from compare(f"stats/{camera}/{key}", noted[key], right[key], np.full((1, 1, 1), tolerance * scale))


def check_total_stats(noted: Mapping[str, Stats], episodes: Sequence[Mapping[str, Stats]]) -> Iterator[str]:
    """Statistics of the dataset that are not those of its episodes."""
    for name in episodes[0]:
        if name not in noted:
            yield f"{name} missing"
            continue
        if not all(name in each for each in episodes):
            continue
        right = aggregate([each[name] for each in episodes])
        for key in ("min", "max", "mean", "std", "count"):
            yield from compare(f"{name}/{key}", noted[name][key], right[key], margin(right))


def compare(what: str, noted: NDArray[Any], right: NDArray[Any], tolerance: NDArray[Any]) -> Iterator[str]:
    """One line for an array that differs."""
    if noted.shape != right.shape:
        yield f"{what} has shape {noted.shape}; it must be {right.shape}"
        return
    wrong = np.argwhere(np.abs(noted - right) > tolerance)
    if len(wrong):
        i = tuple(int(k) for k in wrong[0])
        entry = f"[{i[0]}]" if right.size > 1 else ""
        yield f"{what}{entry} is {noted[i]:.6g}; of what is there it is {right[i]:.6g}"
