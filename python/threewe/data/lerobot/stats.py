"""Statistics of an episode's features, as LeRobot 0.6.1 defines them: with quantiles from histograms of 5000 bins.

Means are added in double precision. LeRobot adds those of images in single precision: of a frame's 20,000 pixels over
100 frames the sums lose up to some percent where the image is nearly uniform. The definition is the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe.data.lerobot.features import Feature

QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
BINS = 5000
Stats = dict[str, NDArray[Any]]
"""`min max mean std count q01 q10 q50 q90 q99` of one feature; `count` are frames."""


def column_stats(values: NDArray[Any]) -> Stats:
    """Statistics of a column `(frames,)` or `(frames, entries)`; further axes count as more rows, as in LeRobot."""
    rows = values.reshape(-1, 1) if values.ndim == 1 else values.reshape(-1, values.shape[-1])
    rows = rows.astype(np.result_type(rows.dtype, np.float32), copy=False)
    columns = [(rows[:, i], None) for i in range(rows.shape[1])]
    return _stats(columns, len(values), single=len(values) < 2)


class PixelCounts:
    """How often each level occurs in the sampled images of a camera, in memory that does not grow with them."""

    def __init__(self, length: int, feature: Feature) -> None:
        self.sampled = frozenset(sampled_frames(length))
        self.levels = np.arange(65536 if feature.is_depth else 256)
        self.counts = [np.zeros(len(self.levels), np.int64) for _ in range(1 if feature.is_depth else 3)]
        self.scale = feature.levels_per_unit
        self.frames = 0

    def add(self, i: int, image: NDArray[Any]) -> None:
        """Counts frame i, `(h, w, 3)` of colours or `(h, w)` of depths, if it is one of those sampled."""
        if i not in self.sampled:
            return
        self.frames += 1
        pixels = thinned(image).reshape(-1, len(self.counts))
        for channel, count in enumerate(self.counts):
            count += np.bincount(pixels[:, channel], minlength=len(self.levels))

    def stats(self) -> Stats:
        """Each `(channels, 1, 1)`, colours in 0 to 1, depths in the unit of the feature."""
        columns = [(self.levels[count > 0].astype(np.float32), count[count > 0]) for count in self.counts]
        stats = _stats(columns, self.frames, single=False)
        shape = (-1, 1, 1)
        return {
            name: value if name == "count" else (value / self.scale).reshape(shape) for name, value in stats.items()
        }


def sampled_frames(length: int) -> list[int]:
    """The frames of an episode that image statistics are taken of: all up to 100, length^0.75 of long ones."""
    count = max(min(length, 100), min(int(length**0.75), 10_000))
    return [int(i) for i in np.round(np.linspace(0, length - 1, count))]


def thinned(image: NDArray[Any]) -> NDArray[Any]:
    """An image `(h, w, channels)`; of a large one each n-th row and column, about 150 of its longer side."""
    height, width = image.shape[:2]
    if max(width, height) < 300:
        return image
    step = int(width / 150) if width > height else int(height / 150)
    return image[::step, ::step]


def aggregate(episodes: Sequence[Stats]) -> Stats:
    """Statistics of all episodes together; quantiles are weighted means, as in LeRobot."""
    counts = np.array([stats["count"][0] for stats in episodes], float)
    weights = counts / counts.sum()

    def mean(values: Sequence[NDArray[Any]]) -> NDArray[Any]:
        return np.tensordot(weights, np.stack(values), axes=1)

    total = mean([stats["mean"] for stats in episodes])
    spread = mean([stats["std"] ** 2 + (stats["mean"] - total) ** 2 for stats in episodes])
    result: Stats = {
        "min": np.min([stats["min"] for stats in episodes], axis=0),
        "max": np.max([stats["max"] for stats in episodes], axis=0),
        "mean": total,
        "std": np.sqrt(spread),
        "count": np.array([int(counts.sum())]),
    }
    for name in QUANTILES:
        if all(name in stats for stats in episodes):
            result[name] = mean([stats[name] for stats in episodes])
    return result


def table_stats(columns: Mapping[str, NDArray[Any]], features: Mapping[str, Feature]) -> dict[str, Stats]:
    """Statistics of all columns of numbers."""
    return {
        name: column_stats(values)
        for name, values in columns.items()
        if features[name].dtype != "string" and not features[name].is_camera
    }


def frames_stats(image: Callable[[int], NDArray[Any]], length: int, feature: Feature) -> Stats:
    """Statistics of a camera's images, of which `image(i)` gives each one that is sampled."""
    counts = PixelCounts(length, feature)
    for i in sorted(counts.sampled):
        counts.add(i, image(i))
    return counts.stats()


Weighted = tuple[NDArray[Any], NDArray[np.int64] | None]
"""Values, and how often each occurs."""


def _stats(columns: Sequence[Weighted], frames: int, *, single: bool) -> Stats:
    mean = np.array([np.average(values.astype(float), weights=counts) for values, counts in columns])
    around = [np.average((values - m) ** 2, weights=counts) for m, (values, counts) in zip(mean, columns, strict=True)]
    stats: Stats = {
        "min": np.array([values.min() for values, _ in columns], float),
        "max": np.array([values.max() for values, _ in columns], float),
        "mean": mean,
        "std": np.sqrt(around),
        "count": np.array([frames]),
    }
    quantiles = [_quantiles(values, counts) for values, counts in columns]
    for i, name in enumerate(QUANTILES):
        stats[name] = mean.copy() if single else np.array([found[i] for found in quantiles], float)
    return stats


def _quantiles(values: NDArray[Any], counts: NDArray[np.int64] | None) -> list[float]:
    """Linear within the bins of a histogram, whose edges have the precision of the values."""
    edges = np.linspace(values.min() - 1e-10, values.max() + 1e-10, BINS + 1)
    histogram, _ = np.histogram(values, bins=edges, weights=counts)
    below = np.cumsum(histogram)
    found = []
    for quantile in QUANTILES.values():
        target = quantile * below[-1]
        i = int(np.searchsorted(below, target))
        if i == 0:
            found.append(edges[0])
            continue
        i = min(i, BINS - 1)
        share = (target - below[i - 1]) / max(below[i] - below[i - 1], 1)
        found.append(edges[i] + share * (edges[i + 1] - edges[i]))
    return [float(value) for value in found]
