"""The published claims: results of full runs, a file for each area, and the page docs/claims.md made of them."""

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from verify.cases.trees import ROOT
from verify.harness.journal import Revision, machine
from verify.harness.rows import Row, Verdict
from verify.harness.running import Experiment

RESULTS = ROOT / "verify/results"
PAGE = ROOT / "docs/claims.md"
HEAD = """\
# Claims

What 3we does, as `./dev verify` measured it: every row of every area, misses included. Cases are drawn from a seed that
follows from the commit, so nothing was tuned on them. *95 %* is the interval of the figure; *would catch* the drop that
a run like this one catches nine times in ten. How rows are judged: [verify](../verify/README.md). This page is made of
the files in `verify/results` by `./dev verify claims`.
"""


@dataclass(frozen=True)
class Area:
    """One of the programs of `verify`."""

    title: str  # in a line
    experiments: list[Experiment]


def save(
    area: str, experiment: Experiment, revision: Revision, seed: int, judged: list[tuple[Row, Verdict]], cases: int
) -> Path:
    """Writes what a full run of one experiment came to, in place of what was on file of it."""
    rows = [
        {
            "row": row.name,
            "status": verdict.status,
            "figure": verdict.figure,
            "target": verdict.target,
            "interval": verdict.interval,
            "power": verdict.power,
            **({"why": row.known_miss.why} if row.known_miss else {}),
        }
        for row, verdict in judged
    ]
    run = {"commit": revision.commit, "seed": seed, "machine": machine(), "cases": cases, "rows": rows}
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / f"{area}.json"
    runs = json.loads(path.read_text()) if path.exists() else {}
    path.write_text(json.dumps(runs | {experiment.name: run}, indent=1) + "\n")
    return path


def page(areas: Mapping[str, Area], results: Path = RESULTS) -> str:
    """The page: of each area what is on file of its experiments."""
    files = {name: results / f"{name}.json" for name in areas}
    runs = {name: json.loads(file.read_text()) if file.exists() else {} for name, file in files.items()}
    for name, area in areas.items():
        for experiment in area.experiments:
            for row in runs[name].get(experiment.name, {"rows": []})["rows"]:
                row["status"] = status_of(row, experiment)
    parts = [HEAD, summary(areas, runs)]
    parts += [section(name, area, runs[name]) for name, area in areas.items() if runs[name]]
    return "\n".join(parts)


def status_of(row: dict[str, Any], experiment: Experiment) -> str:
    """Of a row on file: what passed in a run that would have caught nothing of use decides nothing."""
    status: str = row["status"]
    tests = [one.test for one in experiment.rows if one.test and one.name == row["row"]]
    test = next((one for one in tests if one.wanted() == row["target"]), None)
    caught = re.match(r"(?:[<>]=|violations in) (-?[\d.]+(?:e[+-]?\d+)?)(%?)", row["power"])
    if status != "pass" or (caught and test is None):  # a row that was another then
        return status
    if not caught or test is None:
        return "info"
    drop = float(caught[1]) * (0.01 if caught[2] else 1.0)
    return "pass" if test.has_power(math.log(drop) if getattr(test, "geometric", False) else drop) else "info"


def summary(areas: Mapping[str, Area], runs: dict[str, Any]) -> str:
    """A line for each area, also for those of which no full run is on file."""
    lines = ["| area | pass | FAIL | known miss | info | not shown | on file |", "|---|---|---|---|---|---|---|"]
    for name, area in areas.items():
        on_file = [runs[name][one.name] for one in area.experiments if one.name in runs[name]]
        statuses = [row["status"] for run in on_file for row in run["rows"]]
        counts = [statuses.count(status) for status in ("pass", "FAIL", "known miss", "info", "not shown")]
        link = f"[{name}](#{name})" if on_file else name
        share = f"{len(on_file)} of {len(area.experiments)} experiments"
        lines.append(f"| {link} | {' | '.join(map(str, counts))} | {share} |")
    return "\n".join([*lines, ""])


def section(name: str, area: Area, runs: dict[str, Any]) -> str:
    """The rows of one area, a table for each experiment."""
    lines = [f"## {name}", "", area.title, ""]
    for experiment in (one.name for one in area.experiments):
        if experiment not in runs:
            lines += [f"**{experiment}**: no full run on file", ""]
            continue
        run = runs[experiment]
        of = f"{run['cases']} cases, commit {run['commit']}, seed {run['seed']}, on {run['machine']}"
        lines += [f"**{experiment}**: {of}", ""]
        lines += ["| | | figure | target | 95 % | would catch |", "|---|---|---|---|---|---|"]
        lines += [line(row) for row in run["rows"]] + [""]
    return "\n".join(lines)


def line(row: dict[str, Any]) -> str:
    """One row; what misses its target stands out."""
    status = row["status"] if row["status"] in ("pass", "info") else f"**{row['status']}**"
    figure = f"{row['figure']} ({row['why']})" if row["status"] == "known miss" else row["figure"]
    cells = [status, row["row"], figure, row["target"], row["interval"], row["power"]]
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"
