"""Rows: one claim each. What the cases show becomes a figure; a test says whether it holds, and what it would catch.

A row passes or fails on its figure; known to miss its target, it fails where its figure is worse than the known one by
more than chance. Not all cases run decide less: what they miss by chance is `info`, and so is a row of all cases
together. A row that could not even notice a fall to half of its target, and one that states no power, may fail, and is
else printed as `info` and never counted as passed. A broken case is a FAIL of every row of its experiment; what cannot
be judged is a FAIL too.
"""

import math
import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

Case = dict[str, Any]
Seen = tuple[float, ...]
"""What a run saw, as a few numbers: for each kind of test what its docstring says."""
CAUGHT = 0.9
"""The chance with which a run catches the drop that is printed as its power."""
NO_POWER = "nothing"


@dataclass(frozen=True)
class Test(ABC):
    """A figure is at least, or at most, `target`: a count (counts.py), or a mean (means.py)."""

    target: float
    at_least: bool = True

    @abstractmethod
    def value(self, seen: Seen) -> float:
        """What is compared with the target."""

    @abstractmethod
    def limits(self, seen: Seen) -> tuple[float, float]:
        """The value's interval of 95 %."""

    @abstractmethod
    def drop(self, seen: Seen) -> float:
        """The true value nearest to the target of which such a run misses it nine times in ten; nan: none."""

    @abstractmethod
    def shown(self, value: float) -> str:
        """A value in the target's form."""

    @abstractmethod
    def figure(self, seen: Seen) -> str:
        """What was seen."""

    @property
    def half(self) -> float:
        """The fall that a row must notice to pass: to half of what is to be much, to twice of what is to be little."""
        return self.target * (0.5 if self.at_least else 2.0)

    def holds(self, seen: Seen) -> bool:
        """Whether the value meets the target."""
        return self.value(seen) >= self.target if self.at_least else self.value(seen) <= self.target

    def worse(self, seen: Seen, bar: float) -> bool:
        """Whether the value is worse than the bar by more than chance, one-sided 2.5 %; where it is no number, too."""
        low, high = self.limits(seen)
        return not (high >= bar if self.at_least else low <= bar)

    def interval(self, seen: Seen) -> str:
        low, high = self.limits(seen)
        return f"[{self.shown(low)}, {self.shown(high)}]" if math.isfinite(high - low) else ""

    def wanted(self) -> str:
        return f"{'>=' if self.at_least else '<='} {self.shown(self.target)}"

    def power(self, seen: Seen) -> str:
        drop = self.drop(seen)
        enough = drop >= self.half if self.at_least else drop <= self.half
        return self.caught(drop) if enough else NO_POWER

    def caught(self, drop: float) -> str:
        return f"{'<=' if self.at_least else '>='} {self.shown(drop)}"


@dataclass(frozen=True)
class Verdict:
    """What a row comes to."""

    figure: str
    target: str
    status: str  # "pass", "FAIL", "known miss", "info" where nothing is decided, or "not shown"
    interval: str = ""
    power: str = ""  # the drop that is caught nine times in ten


@dataclass(frozen=True)
class KnownMiss:
    """Why a row misses its target, and the bar: the figure on file. A run that is worse by more than chance fails."""

    why: str
    bar: float


@dataclass(frozen=True)
class Row:
    """One claim. `parts` are what it is about, `seen` what the test makes of them; without a test the row is a whole:
    a figure, a target, and whether it is met, without power.
    """

    name: str
    seen: Callable[[list[Case]], Seen] | None = None
    test: Test | None = None
    whole: Callable[[list[Case]], tuple[str, str, bool | None]] | None = None
    parts: Callable[[Case], Iterable[Case]] = lambda case: [case]
    words: Callable[[list[Case]], str] | None = None  # to go with the figure
    known_miss: KnownMiss | None = None

    @property
    def target(self) -> str:
        """What its test wants; a whole says so with its figure."""
        return self.test.wanted() if self.test else ""

    def judge(self, cases: Sequence[Case], *, complete: bool = True) -> Verdict:
        """The verdict on cases of which none is `not_shown`, all that the experiment has where they are `complete`;
        whatever they hold, it is one.
        """
        broken = sum("error" in case for case in cases)
        if broken:
            return Verdict(f"{broken} of {len(cases)} cases broke", self.target, "FAIL")
        try:
            parts = [part for case in cases for part in self.parts(case)]
            if not parts:
                return Verdict("nothing to judge", self.target, "info")
            return self.judge_whole(parts, complete) if self.test is None else self.judge_seen(parts, complete)
        except Exception:
            why = traceback.format_exc(limit=-1).splitlines()[-1]
            return Verdict(f"not to be judged: {why}", self.target, "FAIL")

    def judge_whole(self, parts: list[Case], complete: bool) -> Verdict:
        assert self.whole is not None
        figure, target, met = self.whole(parts)
        if met is None:
            return Verdict(figure, target, "info")
        return Verdict(figure, target, "info" if met or not complete else "FAIL", power=NO_POWER)

    def judge_seen(self, parts: list[Case], complete: bool) -> Verdict:
        assert self.test is not None
        assert self.seen is not None
        seen, test = self.seen(parts), self.test
        power = test.power(seen)
        figure = test.figure(seen) + (f"; {self.words(parts)}" if self.words else "")
        if test.holds(seen):
            status = "info" if power == NO_POWER else "pass"
        elif self.known_miss:
            status = "FAIL" if test.worse(seen, self.known_miss.bar) else "known miss"
        else:
            status = "FAIL" if complete or test.worse(seen, test.target) else "info"
        return Verdict(figure, test.wanted(), status, test.interval(seen), power)
