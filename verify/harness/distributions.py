"""Distributions behind the rows, besides those of `threewe.benchmark.statistics`: the binomial and the Poisson."""

import math
from collections.abc import Callable

import numpy as np
from threewe.benchmark.statistics import beta_share


def binomial_at_most(hits: int, count: int, share: float) -> float:
    """The chance of no more hits; exact where the share is near 1 and intervals made of deviations are too narrow."""
    if share <= 0.0 or hits >= count:
        return 1.0
    if hits < 0 or share >= 1.0:
        return 0.0
    return beta_share(count - hits, hits + 1, 1.0 - share)


def poisson_at_least(events: int, expected: float) -> float:
    """The chance of so many events or more."""
    if events <= 0:
        return 1.0
    k = np.arange(events)
    logs = k * math.log(expected) - expected - np.array([math.lgamma(i + 1.0) for i in k])
    return float(max(1.0 - np.exp(logs).sum(), 0.0))


def boundary(inside: float, outside: float, holds: Callable[[float], bool]) -> float:
    """The number between the two up to which something holds, by bisection."""
    for _ in range(60):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if holds(middle) else (inside, middle)
    return inside
