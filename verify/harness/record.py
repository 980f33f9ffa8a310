"""The committed record: what samples of earlier commits saw, so that small drops are caught over several runs."""

import json
import math
from pathlib import Path

from verify.cases.trees import ROOT
from verify.harness.rows import Verdict
from verify.harness.sequential import Seen

PATH = ROOT / "verify/record.jsonl"


class Record:
    """One JSON line for each area of each run, oldest first: the numbers that its rows saw."""

    def __init__(self, path: Path = PATH) -> None:
        """Reads what there is."""
        self.path = path
        self.runs = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []

    def earlier(self, area: str, row: str, commit: str, seed: int) -> list[Seen]:
        """What a row saw in runs before; the same commit with the same seed would count the same cases twice."""
        others = [run for run in self.runs if (run["commit"], run["seed"]) != (commit, seed) and run["area"] == area]
        return [tuple(run["rows"][row]) for run in others if row in run["rows"]]

    def add(self, area: str, commit: str, seed: int, verdicts: dict[str, Verdict]) -> None:
        """Puts a run at the end, in place of one with the same cases."""
        # one case alone has no interval
        rows = {name: one.seen for name, one in verdicts.items() if one.seen and all(map(math.isfinite, one.seen))}
        known = (area, commit, seed)
        kept = [run for run in self.runs if (run["area"], run["commit"], run["seed"]) != known]
        self.runs = [*kept, {"area": area, "commit": commit, "seed": seed, "rows": rows}]
        self.path.write_text("".join(json.dumps(run) + "\n" for run in self.runs))
