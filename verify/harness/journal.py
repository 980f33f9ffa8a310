"""What is kept of a run: each case as it finishes, so that an interrupted run goes on, and which code it was."""

import hashlib
import os
import platform
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from threewe.benchmark.runner import Journal

from verify.cases.trees import ROOT


def open_journal(path: Path) -> Journal:
    """The cases that have finished. Those that broke or were not shown are run again next time."""
    journal = Journal(path, keeps=lambda case: "not_shown" not in case)
    if len(journal):
        print(f"{len(journal)} cases were finished before")
    return journal


@dataclass(frozen=True)
class Revision:
    """The code that a run is of."""

    commit: str  # ending in + and a hash where something is not committed
    seed: int  # that follows from the commit: nothing was tuned on its cases

    @staticmethod
    def here() -> "Revision":
        """Of the working tree. Results and records of earlier runs are no code."""
        own = ["--", ".", ":!verify/results", ":!verify/record.jsonl", ":!docs/claims.md"]
        commit = git("rev-parse", "--short=10", "HEAD") or "0"
        changes = git("diff", "HEAD", *own) + git("ls-files", "--others", "--exclude-standard", *own)
        suffix = f"+{hashlib.sha256(changes.encode()).hexdigest()[:6]}" if changes else ""
        return Revision(commit + suffix, int(commit[:8], 16))


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
        digest = hashlib.sha256(f"{seed}/{name}/{index}".encode()).digest()
        yield int.from_bytes(digest[:4], "little")
