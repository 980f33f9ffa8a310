"""Sequential tests of a sample against its target, over this run and those on record (A. Wald 1945, E. S. Page 1954).

Each run of CI multiplies the odds of a drop, over those of the target just met, by what it saw. With odds of 1 and less
the row passes, and a new test begins; at 1 / ALPHA it fails; in between it is undecided, and later runs go on with it.
A test of a target that is just met ever fails with a chance of at most ALPHA (J. Ville 1939), however many runs it
takes, and a run begins at most one test a row: so a whole run of at most ROWS rows fails by chance at most once in
1 / FALSE_ALARMS. The drop is the one that RUNS runs of this size catch nine times in ten.
"""

import math
from collections.abc import Iterable
from typing import Protocol

FALSE_ALARMS = 0.01  # of a run of CI in which every target is just met
ROWS = 200  # in it, at most
ALPHA = FALSE_ALARMS / ROWS
CAUGHT = 0.9  # of planted drops
RUNS = 5  # of CI, within which a drop is caught
ALARM = math.log(1.0 / ALPHA)  # of log odds

Seen = tuple[float, ...]
"""What a run saw, as a few numbers that a record keeps: for each kind of test what its `seen` says."""


class Test(Protocol):
    """A kind of test against a target: of counts (counts.py), or of means (means.py)."""

    def holds(self, seen: Seen, /) -> bool:
        """Whether the figure meets the target."""

    def figure(self, seen: Seen, /) -> str:
        """What was seen."""

    def interval(self, seen: Seen, /) -> str:
        """Of 95 %."""

    def wanted(self) -> str:
        """The target."""

    def drop(self, seen: Seen, runs: int, /) -> float:
        """What so many runs of this size catch nine times in ten; nan: nothing."""

    def has_power(self, drop: float, /) -> bool:
        """Whether that is of any use."""

    def power(self, drop: float, /) -> str:
        """The drop in words."""

    def log_odds(self, seen: Seen, drop: float, /) -> float:
        """Of the drop over the target just met."""


def log_odds(test: Test, drop: float, earlier: Iterable[Seen], now: Seen) -> float:
    """Of the drop over the target, after this run and those on record. After an alarm on record a new test begins."""
    odds = 0.0
    for seen in earlier:
        odds = max(odds + test.log_odds(seen, drop), 0.0)
        odds = 0.0 if odds >= ALARM else odds
    return odds + test.log_odds(now, drop)
