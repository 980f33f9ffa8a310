"""Rows: one claim each. What the cases show becomes a figure; a test says whether it holds, and what it would catch.

full run     a row passes, or fails, on its figure
a sample     a row fails where the sequential test of it and the record gives the alarm, and passes where they speak for
             the target; what is undecided is printed as `info`
a row that could not even notice a fall to half of its target, and one that states no power, may fail, and is else
printed as `info` and never counted as passed
a broken case is a FAIL of every row of its experiment; what cannot be judged is a FAIL too
"""

import math
import traceback
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from verify.harness.counts import Always, Share
from verify.harness.sequential import ALARM, RUNS, Seen, Test, log_odds

Case = dict[str, Any]


@dataclass(frozen=True)
class Verdict:
    """What a row comes to."""

    figure: str
    target: str
    status: str  # "pass", "FAIL", "known miss", "info" where nothing is decided, or "not shown"
    interval: str = ""
    power: str = ""  # the drop that is caught nine times in ten
    seen: Seen = ()  # for the record


@dataclass(frozen=True)
class KnownMiss:
    """Why a row misses its target, and the figure that it had: a sample is tested against that."""

    why: str
    figure: float


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
    full_only: bool = False  # too few cases of a sample are about it

    def judge(self, cases: Sequence[Case], *, sample: bool = False, earlier: Iterable[Seen] = ()) -> Verdict:
        """The verdict on cases of which none is `not_shown`; whatever they hold, it is one."""
        broken = sum("error" in case for case in cases)
        target = self.test.wanted() if self.test else ""
        if broken:
            return Verdict(f"{broken} of {len(cases)} cases broke", target, "FAIL")
        try:
            parts = [part for case in cases for part in self.parts(case)]
            if not parts:
                return Verdict("nothing to judge", target, "info")
            return self.judge_whole(parts, sample) if self.test is None else self.judge_seen(parts, sample, earlier)
        except Exception:
            return Verdict(f"not to be judged: {traceback.format_exc(limit=-1).splitlines()[-1]}", target, "FAIL")

    def judge_whole(self, parts: list[Case], sample: bool) -> Verdict:
        assert self.whole is not None
        figure, target, met = self.whole(parts)
        if met is None:
            return Verdict(figure, target, "info")
        if sample:
            return Verdict(figure, target, "info", power="nothing: only full runs are judged")
        return Verdict(figure, target, "info" if met else self.missed(), power="nothing")

    def judge_seen(self, parts: list[Case], sample: bool, earlier: Iterable[Seen]) -> Verdict:
        assert self.test is not None
        assert self.seen is not None
        seen, test = self.seen(parts), self.test
        figure = test.figure(seen) + (f"; {self.words(parts)}" if self.words else "")
        runs = RUNS if sample else 1
        if sample and self.known_miss:  # it is to get no worse
            test = missed_by(test, self.known_miss.figure)
        drop = test.drop(seen, runs)
        able = test.has_power(drop)
        power = (f"{test.power(drop)} in {runs} such run{'s' * (runs > 1)}") if math.isfinite(drop) else "nothing"
        if sample:
            status = self.status_of(log_odds(test, drop, earlier, seen), able)
            if status == "info":
                power += ": undecided" if able else ": too little to judge by"
        else:
            status = self.missed() if not test.holds(seen) else "pass" if able else "info"
        return Verdict(figure, self.test.wanted(), status, self.test.interval(seen), power, seen)

    def status_of(self, odds: float, able: bool) -> str:
        """Of a sample; what is undecided, or could not notice much, decides nothing."""
        if odds >= ALARM:
            return "FAIL"
        if self.known_miss:
            return "known miss"
        return "pass" if able and odds <= 0.0 else "info"

    def missed(self) -> str:
        return "known miss" if self.known_miss else "FAIL"


def missed_by(test: Test, figure: float) -> Test:
    """The test against what was measured instead."""
    return Share(figure) if isinstance(test, Always) else replace(test, target=figure)
