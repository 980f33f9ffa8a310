"""Tests of means: of values, of timings, and of what cases count."""

import math
from dataclasses import dataclass

from threewe.benchmark.statistics import NORMAL, Z95, student_quantile, wilson

from verify.harness.rows import CAUGHT, Seen, Test

LARGE = 700.0  # of logarithms whose numbers can be written


@dataclass(frozen=True)
class Mean(Test):
    """A mean over the cases, or the ratio of two. Seen: mean, its standard error, cases."""

    form: str = "{:.3g}"

    def value(self, seen: Seen) -> float:
        return seen[0]

    def limits(self, seen: Seen) -> tuple[float, float]:
        if seen[2] < 2:
            return -math.inf, math.inf
        half = student_quantile(Z95, int(seen[2]) - 1) * self.error(seen, seen[0])
        return seen[0] - half, seen[0] + half

    def drop(self, seen: Seen) -> float:
        """By Student's distribution; nan where cases show no error."""
        if seen[2] < 2:
            return math.nan
        errors, drop = student_quantile(NORMAL.inv_cdf(CAUGHT), int(seen[2]) - 1), self.target
        for _ in range(100):  # an error that depends on the mean is found step by step
            off = errors * self.error(seen, drop)
            drop = 0.5 * (drop + (self.target - off if self.at_least else self.target + off))
        return drop if off > 0.0 else math.nan

    def error(self, seen: Seen, mean: float) -> float:
        """The standard error of this run, had it this mean."""
        del mean
        return seen[1]

    def shown(self, value: float) -> str:
        return self.form.format(value)

    def figure(self, seen: Seen) -> str:
        return f"mean {self.shown(self.value(seen))} of {seen[2]:.0f}"


@dataclass(frozen=True)
class GeometricMean(Mean):
    """The same, seen as logarithms: for timings, which differ by factors."""

    def value(self, seen: Seen) -> float:
        return exponential(seen[0])

    def limits(self, seen: Seen) -> tuple[float, float]:
        low, high = super().limits(seen)
        return exponential(low), exponential(high)

    def drop(self, seen: Seen) -> float:
        return exponential(Mean(math.log(self.target), self.at_least).drop(seen))


@dataclass(frozen=True)
class Counted(Mean):
    """A share of what cases count, such as the drives in one place, which are alike.

    Seen: share, its standard error from case to case, cases, counted.
    """

    form: str = "{:.1%}"

    @property
    def half(self) -> float:
        """Of what is to be rare twice as much, or one more in a hundred."""
        return super().half if self.at_least else max(2.0 * self.target, self.target + 0.01)

    def limits(self, seen: Seen) -> tuple[float, float]:
        if seen[2] < 2:
            return -math.inf, math.inf
        low, high = wilson(round(seen[0] * seen[3]), int(seen[3]))
        half = student_quantile(Z95, int(seen[2]) - 1) * seen[1]
        return max(min(low, seen[0] - half), 0.0), min(max(high, seen[0] + half), 1.0)

    def error(self, seen: Seen, mean: float) -> float:
        """No less than if all that is counted were alone: that a few cases are alike shows nothing."""
        share = min(max(mean, 0.0), 1.0)
        return max(seen[1], math.sqrt(share * (1.0 - share) / seen[3]))

    def figure(self, seen: Seen) -> str:
        return f"{seen[0] * seen[3]:.0f}/{seen[3]:.0f} = {self.shown(seen[0])}"


def exponential(value: float) -> float:
    return math.exp(min(value, LARGE)) if math.isfinite(value) else value
