"""Tests of means: of values, of timings, and of what cases count."""

import math
from dataclasses import dataclass

from threewe.benchmark.statistics import NORMAL, Z95, student_quantile, wilson

from verify.harness.distributions import normal_score
from verify.harness.sequential import ALARM, CAUGHT, RUNS, Seen

LARGE = 700.0  # of logarithms whose numbers can be written


@dataclass(frozen=True)
class Mean:
    """A mean over the cases, or the ratio of two, is at least or at most `target`.

    Seen: mean, its standard error, cases. Each run is turned into one normal score by Student's t.
    """

    target: float
    at_least: bool
    form: str = "{:.3g}"
    geometric: bool = False  # of logarithms: for timings, which differ by factors

    def holds(self, seen: Seen) -> bool:
        return seen[0] >= self.bound if self.at_least else seen[0] <= self.bound

    @property
    def bound(self) -> float:
        return math.log(self.target) if self.geometric else self.target

    def figure(self, seen: Seen) -> str:
        return f"mean {self.shown(seen[0])} of {seen[2]:.0f}"

    def interval(self, seen: Seen) -> str:
        if seen[2] < 2:
            return ""
        half = student_quantile(Z95, int(seen[2]) - 1) * self.error(seen, seen[0])
        return f"[{self.shown(seen[0] - half)}, {self.shown(seen[0] + half)}]"

    def wanted(self) -> str:
        return f"{'>=' if self.at_least else '<='} {self.form.format(self.target)}"

    def drop(self, seen: Seen, runs: int) -> float:
        """The mean that is so many standard errors of this run beyond the target; nan where cases show no error."""
        if seen[2] < 2:
            return math.nan
        scores, drop = student_quantile(self.shift(runs), int(seen[2]) - 1), self.bound
        for _ in range(100):  # what scatters more where it is lower is found by and by
            off = scores * self.error(seen, drop)
            drop = 0.5 * (drop + (self.bound - off if self.at_least else self.bound + off))
        return drop if off > 0.0 else math.nan

    def error(self, seen: Seen, mean: float) -> float:
        """The standard error of this run, had it this mean."""
        del mean
        return seen[1]

    @staticmethod
    def shift(runs: int) -> float:
        """The normal score of each of so many runs whose sum gives the alarm nine times in ten."""
        z = NORMAL.inv_cdf(CAUGHT)
        return (z + math.sqrt(z * z + 2.0 * ALARM)) / math.sqrt(runs)

    def has_power(self, drop: float) -> bool:
        """It would notice half of what is to be much, and twice of what is to be little."""
        far = self.target * (0.5 if self.at_least else 2.0)
        far = math.log(far) if self.geometric else far
        return drop >= far if self.at_least else drop <= far

    def power(self, drop: float) -> str:
        return f"{'<=' if self.at_least else '>='} {self.shown(drop)}"

    def log_odds(self, seen: Seen, drop: float) -> float:
        del drop  # which is so many standard errors of whatever run
        if seen[2] < 2:
            return math.nan
        off = self.bound - seen[0] if self.at_least else seen[0] - self.bound
        error = self.error(seen, self.bound)
        t = off / error if error > 0.0 else math.inf if off > 0.0 else -math.inf
        score = normal_score(t, int(seen[2]) - 1)
        return self.shift(RUNS) * (score - 0.5 * self.shift(RUNS))

    def shown(self, value: float) -> str:
        return self.form.format(math.exp(min(value, LARGE)) if self.geometric else value)


@dataclass(frozen=True)
class Counted(Mean):
    """A share of what cases count, such as the drives in one place, which are alike.

    Seen: share, its standard error from case to case, cases, counted.
    """

    form: str = "{:.1%}"

    def figure(self, seen: Seen) -> str:
        return f"{seen[0] * seen[3]:.0f}/{seen[3]:.0f} = {self.shown(seen[0])}"

    def interval(self, seen: Seen) -> str:
        if seen[2] < 2:
            return ""
        low, high = wilson(round(seen[0] * seen[3]), int(seen[3]))
        half = student_quantile(Z95, int(seen[2]) - 1) * seen[1]
        low, high = max(min(low, seen[0] - half), 0.0), min(max(high, seen[0] + half), 1.0)
        return f"[{self.shown(low)}, {self.shown(high)}]"

    def has_power(self, drop: float) -> bool:
        """It would notice half of what is to be much; of what is to be rare, twice as much or one more in a hundred."""
        return drop >= 0.5 * self.target if self.at_least else drop <= max(2.0 * self.target, self.target + 0.01)

    def error(self, seen: Seen, mean: float) -> float:
        """No less than if all that is counted were alone: that a few cases are alike shows nothing."""
        share = min(max(mean, 0.0), 1.0)
        return max(seen[1], math.sqrt(share * (1.0 - share) / seen[3]))
