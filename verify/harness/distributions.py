"""Distributions behind the rows: intervals of shares and means, tails of Student's t, the binomial and the Poisson."""

import math
from statistics import NormalDist

import numpy as np

NORMAL = NormalDist()
Z95 = NORMAL.inv_cdf(0.975)


def wilson(hits: int, count: int, z: float = Z95) -> tuple[float, float]:
    """The 95 % interval of a proportion (E. B. Wilson, 1927)."""
    share = hits / count
    middle = share + z * z / (2 * count)
    half = z * math.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    scale = 1 + z * z / count
    low, high = (middle - half) / scale, (middle + half) / scale
    return (low if hits > 0 else 0.0), (high if hits < count else 1.0)  # exact at the ends, where rounding is not


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


def normal_score(t: float, freedom: int, most: float = 8.0) -> float:
    """The z of a normal distribution that is exceeded as often as `t` of Student's."""
    if not math.isfinite(t):
        return math.copysign(most, t)
    tail = max(student_tail(abs(t), freedom), NORMAL.cdf(-most))
    return math.copysign(min(-NORMAL.inv_cdf(tail), most), t)


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
