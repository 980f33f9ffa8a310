"""What is kept of a run: each case as it finishes, so that an interrupted run goes on, and which code it was."""

import hashlib
import json
import os
import platform
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from verify.cases.trees import ROOT
from verify.harness.rows import Case


class Journal:
    """The cases that have finished, one JSON line each. Those that broke or were not shown are run again next time."""

    def __init__(self, path: Path) -> None:
        """Reads what there is."""
        self.path = path
        self.lock = Lock()
        self.known: dict[tuple[str, int], tuple[Case, float]] = {}
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists():
            complete = path.read_text().rpartition("\n")[0]  # the last line may have been cut off
            path.write_text(complete + "\n" if complete else "")
            lines = [json.loads(line) for line in complete.splitlines()]
            finished = [line for line in lines if not {"error", "not_shown"} & line["case"].keys()]
            self.known = {(line["experiment"], line["seed"]): (line["case"], line["seconds"]) for line in finished}
            print(f"{len(self.known)} cases were finished before")

    def find(self, experiment: str, seed: int) -> tuple[Case, float] | None:
        """A finished case, and the seconds that it took."""
        return self.known.get((experiment, seed))

    def add(self, experiment: str, seed: int, case: Case, seconds: float) -> None:
        """Writes a case down, and shows what broke."""
        if "error" in case:
            print(f"{experiment}, seed {seed}: {case['error']}", file=sys.stderr, flush=True)
        line = {"experiment": experiment, "seed": seed, "seconds": round(seconds, 3), "case": case}
        with self.lock, self.path.open("a") as file:
            file.write(json.dumps(line) + "\n")


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
