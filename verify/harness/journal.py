"""What is kept of a run: each case as it finishes, so that an interrupted run goes on, and which code it was."""

import hashlib
import math
import os
import platform
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date
from pathlib import Path

from threewe.benchmark.runner import Finished, Journal

from verify.cases.trees import ROOT

OUT_OF_TIME = Finished({}, "out of time")


class CaseJournal(Journal):
    """The cases that have finished. Those that broke or were not shown are run again next time; from `deadline` on, of
    the monotonic clock, none begins.
    """

    def __init__(self, path: Path, deadline: float = math.inf) -> None:
        super().__init__(path, keeps=lambda case: "not_shown" not in case)
        self.deadline = deadline

    def find(self, key: str) -> Finished | None:
        return super().find(key) or (OUT_OF_TIME if time.monotonic() >= self.deadline else None)


@dataclass(frozen=True)
class Revision:
    """The code that a run is of."""

    commit: str  # ending in + and a hash where something is not committed
    seed: int  # that follows from the commit: nothing was tuned on its cases

    @staticmethod
    def here() -> "Revision":
        """Of the working tree. Results of earlier runs are no code."""
        own = ["--", ".", ":!verify/results", ":!verify/meanings.yaml", ":!docs/claims.md"]
        commit = git("rev-parse", "--short=10", "HEAD") or "0"
        changes = git("diff", "HEAD", *own) + git("ls-files", "--others", "--exclude-standard", *own)
        suffix = f"+{hashlib.sha256(changes.encode()).hexdigest()[:6]}" if changes else ""
        return Revision(commit + suffix, int(commit[:8], 16))

    def seed_of(self, day: date) -> int:
        """That of a drawn run on that day."""
        return number(f"{self.commit}/{day}")


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True).stdout.strip()


def machine() -> str:
    """What the figures were measured on."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    models = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return f"{models[0] if models else platform.machine()}, {os.cpu_count()} CPUs"


def seeds(seed: int, name: str, count: int) -> Iterator[int]:
    """The seeds of an experiment's first cases: the same whatever else runs."""
    for index in range(count):
        yield number(f"{seed}/{name}/{index}")


def number(text: str) -> int:
    """32 bits that look drawn."""
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "little")
