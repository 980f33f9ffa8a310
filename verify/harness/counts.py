"""Tests of counts: of a share, of what is always so, of a rate."""

import math
from dataclasses import dataclass

from threewe.benchmark.statistics import Z95, wilson

from verify.harness.distributions import binomial_at_most, boundary, poisson_at_least
from verify.harness.rows import CAUGHT, Seen, Test


@dataclass(frozen=True)
class Share(Test):
    """A share of cases is at least `target`. Seen: hits, cases."""

    def value(self, seen: Seen) -> float:
        return seen[0] / seen[1]

    def limits(self, seen: Seen) -> tuple[float, float]:
        return wilson(int(seen[0]), int(seen[1]))

    def drop(self, seen: Seen) -> float:
        """By the binomial distribution."""
        count = int(seen[1])
        most = math.ceil(self.target * count - 1e-9) - 1  # hits that miss the target
        return boundary(0.0, self.target, lambda share: binomial_at_most(most, count, share) >= CAUGHT)

    def shown(self, value: float) -> str:
        return f"{value:.1%}"

    def figure(self, seen: Seen) -> str:
        return f"{seen[0]:.0f}/{seen[1]:.0f} = {self.shown(self.value(seen))}"


@dataclass(frozen=True)
class Always(Share):
    """Something holds in every case: one violation is one too many. Seen: hits, cases."""

    target: float = 1.0

    def figure(self, seen: Seen) -> str:
        return f"{seen[0]:.0f}/{seen[1]:.0f}"

    def wanted(self) -> str:
        return "all"

    def caught(self, drop: float) -> str:
        rate = 1.0 - drop
        return f"violations in {rate:.2g} of cases" if rate < 0.001 else f"violations in {rate:.1%} of cases"


@dataclass(frozen=True)
class Rate(Test):
    """Events come at most so often. Seen: events, exposure in the unit of the rate."""

    at_least: bool = False

    @property
    def half(self) -> float:
        """Ten times as many: rare events are few."""
        return 10.0 * self.target

    def value(self, seen: Seen) -> float:
        return seen[0] / seen[1]

    def limits(self, seen: Seen) -> tuple[float, float]:
        low = max(math.sqrt(seen[0]) - 0.5 * Z95, 0.0) ** 2 / seen[1]  # roots of counts scatter by a half
        high = (math.sqrt(seen[0] + 1.0) + 0.5 * Z95) ** 2 / seen[1]
        return low, high

    def drop(self, seen: Seen) -> float:
        """By the Poisson distribution."""
        least = math.floor(self.target * seen[1] + 1e-9) + 1  # events that miss the target
        far = self.target + (10.0 + 2.0 * least) / seen[1]
        return boundary(far, self.target, lambda rate: poisson_at_least(least, rate * seen[1]) >= CAUGHT)

    def shown(self, value: float) -> str:
        return f"{value:.3g}"

    def figure(self, seen: Seen) -> str:
        return f"{seen[0]:.0f} in {seen[1]:.1f} = {self.shown(self.value(seen))}"
