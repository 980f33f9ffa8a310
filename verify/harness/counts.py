"""Tests of counts: of a share, of what is always so, of a rate."""

import math
from dataclasses import dataclass

from threewe.benchmark.statistics import Z95, wilson

from verify.harness.distributions import binomial_at_most, poisson_at_least
from verify.harness.sequential import ALARM, CAUGHT, Seen


@dataclass(frozen=True)
class Share:
    """A share of cases is at least `target` < 1. Seen: hits, cases."""

    target: float

    def holds(self, seen: Seen) -> bool:
        return seen[0] >= self.target * seen[1]

    def figure(self, seen: Seen) -> str:
        return f"{seen[0]:.0f}/{seen[1]:.0f} = {seen[0] / seen[1]:.1%}"

    def interval(self, seen: Seen) -> str:
        low, high = wilson(int(seen[0]), int(seen[1]))
        return f"[{low:.1%}, {high:.1%}]"

    def wanted(self) -> str:
        return f">= {self.target:.1%}"

    def drop(self, seen: Seen, runs: int) -> float:
        """The largest share so low that all cases of the runs together give the alarm nine times in ten; nan: none."""
        count = int(seen[1]) * runs

        def is_caught(share: float) -> bool:
            gain, loss = math.log(share / self.target), math.log((1.0 - share) / (1.0 - self.target))
            most = math.floor((count * loss - ALARM) / (loss - gain) + 1e-9)  # hits that still give the alarm
            return binomial_at_most(most, count, share) >= CAUGHT

        low, high = 1e-6, self.target
        if not is_caught(low):
            return math.nan
        for _ in range(30):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if is_caught(middle) else (low, middle)
        return low

    def has_power(self, drop: float) -> bool:
        """It would notice a fall to half of the target."""
        return drop >= 0.5 * self.target

    def power(self, drop: float) -> str:
        return f"<= {drop:.1%}"

    def log_odds(self, seen: Seen, drop: float) -> float:
        hits, misses = seen[0], seen[1] - seen[0]
        return hits * math.log(drop / self.target) + misses * math.log((1.0 - drop) / (1.0 - self.target))


@dataclass(frozen=True)
class Always:
    """Something holds in every case: one violation is one too many. Seen: hits, cases."""

    def holds(self, seen: Seen) -> bool:
        return seen[0] == seen[1]

    def figure(self, seen: Seen) -> str:
        return f"{seen[0]:.0f}/{seen[1]:.0f}"

    def interval(self, seen: Seen) -> str:
        low, high = wilson(int(seen[0]), int(seen[1]))
        return f"[{low:.1%}, {high:.1%}]"

    def wanted(self) -> str:
        return "all"

    def drop(self, seen: Seen, runs: int) -> float:
        """The rate of violations of which the runs see one nine times in ten."""
        return 1.0 - (1.0 - CAUGHT) ** (1.0 / (seen[1] * runs))

    def has_power(self, drop: float) -> bool:
        return drop <= 0.5

    def power(self, drop: float) -> str:
        return f"violations in {drop:.2g} of cases" if drop < 0.001 else f"violations in {drop:.1%} of cases"

    def log_odds(self, seen: Seen, drop: float) -> float:
        return seen[1] * math.log(1.0 - drop) if self.holds(seen) else math.inf


@dataclass(frozen=True)
class Rate:
    """Events come at most so often. Seen: events, exposure in the unit of the rate."""

    target: float

    def holds(self, seen: Seen) -> bool:
        return seen[0] <= self.target * seen[1]

    def figure(self, seen: Seen) -> str:
        return f"{seen[0]:.0f} in {seen[1]:.1f} = {seen[0] / seen[1]:.2f}"

    def interval(self, seen: Seen) -> str:
        low = max(math.sqrt(seen[0]) - 0.5 * Z95, 0.0) ** 2 / seen[1]  # roots of counts scatter by a half
        high = (math.sqrt(seen[0] + 1.0) + 0.5 * Z95) ** 2 / seen[1]
        return f"[{low:.2f}, {high:.2f}]"

    def wanted(self) -> str:
        return f"<= {self.target:g}"

    def drop(self, seen: Seen, runs: int) -> float:
        """The least rate of which all the runs together give the alarm nine times in ten."""
        exposure = seen[1] * runs

        def is_caught(rate: float) -> bool:
            least = math.ceil((ALARM + (rate - self.target) * exposure) / math.log(rate / self.target) - 1e-9)
            return poisson_at_least(least, rate * exposure) >= CAUGHT

        low, high = self.target, 2.0 * self.target
        while not is_caught(high):
            low, high = high, 2.0 * high
        for _ in range(30):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if is_caught(middle) else (middle, high)
        return high

    def has_power(self, drop: float) -> bool:
        """It would notice ten times as many: rare events are few."""
        return drop <= 10.0 * self.target

    def power(self, drop: float) -> str:
        return f">= {drop:.2g}"

    def log_odds(self, seen: Seen, drop: float) -> float:
        return seen[0] * math.log(drop / self.target) - (drop - self.target) * seen[1]
