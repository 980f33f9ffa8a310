"""Sequential tests of a sample against its target, over this run and those on record (A. Wald 1945, E. S. Page 1954).

Each run of CI multiplies the odds of a drop, over those of the target just met, by what it saw. With odds of 1 and less
the row passes, and a new test begins; at 1 / ALPHA it fails; in between it is undecided, and later runs go on with it.
A test of a target that is just met ever fails with a chance of at most ALPHA (J. Ville 1939), however many runs it
takes, and a run begins at most one test a row: so a whole run of at most ROWS rows fails by chance at most once in
1 / FALSE_ALARMS. The drop is the one that RUNS runs of this size catch nine times in ten.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from verify.harness.distributions import (
    NORMAL,
    Z95,
    binomial_at_most,
    normal_score,
    poisson_at_least,
    student_quantile,
    wilson,
)

FALSE_ALARMS = 0.01  # of a run of CI in which every target is just met
ROWS = 200  # in it, at most
ALPHA = FALSE_ALARMS / ROWS
CAUGHT = 0.9  # of planted drops
RUNS = 5  # of CI, within which a drop is caught
ALARM = math.log(1.0 / ALPHA)  # of log odds

Seen = tuple[float, ...]
"""What a run saw, as a few numbers that a record keeps: for each kind of test what its `seen` says."""


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
        return self.form.format(math.exp(value) if self.geometric else value)


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


Test = Share | Always | Mean | Rate  # and Counted, which is a Mean


def log_odds(test: Test, drop: float, earlier: Iterable[Seen], now: Seen) -> float:
    """Of the drop over the target, after this run and those on record. After an alarm on record a new test begins."""
    odds = 0.0
    for seen in earlier:
        odds = max(odds + test.log_odds(seen, drop), 0.0)
        odds = 0.0 if odds >= ALARM else odds
    return odds + test.log_odds(now, drop)
