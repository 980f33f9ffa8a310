"""Distributions behind the rows, besides those of `threewe.benchmark.statistics`: the binomial and the Poisson."""

import math

import numpy as np
from threewe.benchmark.statistics import NORMAL, beta_share, student_tail


def normal_score(t: float, freedom: int, most: float = 8.0) -> float:
    """The z of a normal distribution that is exceeded as often as `t` of Student's."""
    if not math.isfinite(t):
        return math.copysign(most, t)
    tail = max(student_tail(abs(t), freedom), NORMAL.cdf(-most))
    return math.copysign(min(-NORMAL.inv_cdf(tail), most), t)


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
