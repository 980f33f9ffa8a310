"""Intervals of rates and means."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from functools import cache
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

NORMAL = NormalDist()
Z95 = NORMAL.inv_cdf(0.975)
RESAMPLES = 2000


def wilson(hits: int, count: int, z: float = Z95) -> tuple[float, float]:
    """The 95 % interval of a proportion (E. B. Wilson, 1927)."""
    share = hits / count
    middle = share + z * z / (2 * count)
    half = z * math.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    scale = 1 + z * z / count
    low, high = (middle - half) / scale, (middle + half) / scale
    return (low if hits > 0 else 0.0), (high if hits < count else 1.0)  # exact at the ends, where rounding is not


def mean(values: Sequence[float]) -> float:
    """The mean, rounded once: the same bits for every processor and Python."""
    return math.fsum(values) / len(values)


def bootstrap(values: Sequence[float]) -> tuple[float, float]:
    """The 95 % interval of a mean by the percentile bootstrap (B. Efron, 1979): the same bits for the same values."""
    sample = np.asarray(values, float)
    means = sorted(mean(row) for row in sample[_resamples(len(sample))].tolist())
    return _percentile(means, 0.025), _percentile(means, 0.975)


def _percentile(ordered: Sequence[float], share: float) -> float:
    """Between the two nearest values."""
    place = share * (len(ordered) - 1)
    below = math.floor(place)
    low, high = ordered[below], ordered[min(below + 1, len(ordered) - 1)]
    return low + (place - below) * (high - low)


@cache
def _resamples(count: int) -> NDArray[np.int64]:
    """(RESAMPLES, count) indices, by a generator that no version of Python or NumPy changes."""
    draw = random.Random(0).random
    return np.array([[int(draw() * count) for _ in range(count)] for _ in range(RESAMPLES)])


def student_tail(t: float, freedom: int) -> float:
    """The chance of more than `t` >= 0 (Abramowitz and Stegun 1964, 26.7.1), exact in the far tail too."""
    return 0.5 * beta_share(0.5 * freedom, 0.5, freedom / (freedom + t * t))


def student_quantile(z: float, freedom: int) -> float:
    """The t that is exceeded as often as `z` >= 0 of a normal distribution."""
    tail, low, high = NORMAL.cdf(-z), 0.0, 1.0
    while student_tail(high, freedom) > tail:
        high *= 2.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if student_tail(middle, freedom) > tail else (low, middle)
    return high


def beta_share(a: float, b: float, x: float) -> float:
    """The regularised incomplete beta function, by its continued fraction (Lentz's method, DLMF 8.17.22)."""
    if x <= 0.0 or x >= 1.0:
        return float(x >= 1.0)
    if x > (a + 1.0) / (a + b + 2.0):
        return 1.0 - beta_share(b, a, 1.0 - x)
    tiny = 1e-300
    c, d = 1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0))
    value = d
    for m in range(1, 1000):
        even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
        odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
        for factor in (even, odd):
            d = 1.0 / (1.0 + factor * d or tiny)
            c = 1.0 + factor / c or tiny
            value *= c * d
        if abs(c * d - 1.0) < 1e-14:
            break
    scale = math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x)
    return math.exp(scale) * value / a
