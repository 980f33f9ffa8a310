"""Outcomes now beside those on file: which drives differ, how, and who got better or worse."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping
from dataclasses import dataclass

from threewe.benchmark.statistics import Z95, student_quantile

from verify.pairs.outcomes import Outcome


@dataclass(frozen=True)
class Difference:
    """A drive that is not the one on file to the bit."""

    drive: str
    before: Outcome
    now: Outcome

    def __str__(self) -> str:
        """Names the drive and says what changed, as a reviewer reads it."""
        return f"{self.drive:44} {self.verdict:6} {', '.join(self.changes())}"

    @property
    def verdict(self) -> str:
        """Whether it got better, worse, or is another drive of the same success."""
        if self.before["success"] == self.now["success"]:
            return "other"
        return "better" if self.now["success"] else "WORSE"

    def changes(self) -> list[str]:
        """Returns the figures that differ; where none does, the trajectory alone."""
        found = []
        if self.before["reason"] != self.now["reason"]:
            found.append(f"{self.before['reason'] or 'no reason'} -> {self.now['reason'] or 'no reason'}")
        for name, unit, form in (("seconds", "s", "+.2f"), ("metres", "m", "+.3f")):
            if change := self.now[name] - self.before[name]:
                found.append(f"{change:{form}} {unit}")
        return found or ["the same figures on another trajectory"]


def differences(before: Mapping[str, Outcome], now: Mapping[str, Outcome]) -> list[Difference]:
    """Returns what differs, in the order of the drives now."""
    return [Difference(drive, before[drive], now[drive]) for drive in now if before[drive] != now[drive]]


def summary(before: Mapping[str, Outcome], now: Mapping[str, Outcome]) -> list[str]:
    """Returns the paired differences of all drives: of success, seconds and metres, with their 95 % intervals."""
    pairs = [(before[drive], now[drive]) for drive in now]
    gained = sum(b["success"] < a["success"] for b, a in pairs)
    lost = sum(b["success"] > a["success"] for b, a in pairs)
    lines = [
        f"success: {gained} better, {lost} worse; {paired([a['success'] - b['success'] for b, a in pairs], 100, ' %')}"
    ]
    for name, unit in (("seconds", " s"), ("metres", " m")):
        both = [(b[name], a[name]) for b, a in pairs if a["success"] and b["success"]]
        lines.append(f"{name} where both succeed: {paired([a - b for b, a in both], 1, unit)}")
    return lines


def paired(changes: list[float], scale: float, unit: str) -> str:
    """Returns the mean change of pairs and its 95 % interval by Student's t."""
    if len(changes) < 2:
        return "too few drives"
    mean = scale * statistics.fmean(changes)
    half = scale * student_quantile(Z95, len(changes) - 1) * statistics.stdev(changes) / math.sqrt(len(changes))
    return f"{mean:+.3f}{unit} [{mean - half:+.3f}, {mean + half:+.3f}] a drive"
