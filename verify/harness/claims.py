"""The published claims: results of full runs, a file for each area, and the page docs/claims.md made of them."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from verify.cases.trees import ROOT
from verify.harness.journal import Revision, machine
from verify.harness.rows import Row, Verdict

RESULTS = ROOT / "verify/results"
PAGE = ROOT / "docs/claims.md"
HEAD = """\
# Claims

What 3we does, as `./dev verify` measured it: every row of every area, misses included. Cases are drawn from a seed that
follows from the commit, so nothing was tuned on them. *95 %* is the interval of the figure; *would catch* the drop that
a run like this one catches nine times in ten. How rows are judged: [verify](../verify/README.md). This page is made of
the files in `verify/results` by `./dev verify claims`.
"""


def save(area: str, revision: Revision, seed: int, judged: Iterable[tuple[str, Row, Verdict, int]]) -> Path:
    """Writes what a full run came to: rows with experiment, verdict and number of cases."""
    rows = [
        {
            "experiment": experiment,
            "row": row.name,
            "status": verdict.status,
            "figure": verdict.figure,
            "target": verdict.target,
            "interval": verdict.interval,
            "power": verdict.power,
            "cases": cases,
            **({"why": row.known_miss.why} if row.known_miss else {}),
        }
        for experiment, row, verdict, cases in judged
    ]
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / f"{area}.json"
    run = {"area": area, "commit": revision.commit, "seed": seed, "machine": machine(), "rows": rows}
    path.write_text(json.dumps(run, indent=1) + "\n")
    return path


def page(areas: dict[str, str], results: Path = RESULTS) -> str:
    """The page: of each area, whose first line of help is given, what is on file."""
    files = {area: results / f"{area}.json" for area in areas}
    runs = {area: json.loads(file.read_text()) for area, file in files.items() if file.exists()}
    parts = [HEAD, summary(areas, runs)]
    parts += [section(areas[area], run) for area, run in runs.items()]
    return "\n".join(parts)


def summary(areas: dict[str, str], runs: dict[str, Any]) -> str:
    """A line for each area, also for those of which no full run is on file."""
    lines = ["| area | pass | FAIL | known miss | info | not shown |", "|---|---|---|---|---|---|"]
    for area in areas:
        if area not in runs:
            lines.append(f"| {area} | no full run on file | | | | |")
            continue
        statuses = [row["status"] for row in runs[area]["rows"]]
        counts = [statuses.count(status) for status in ("pass", "FAIL", "known miss", "info", "not shown")]
        lines.append(f"| [{area}](#{area}) | {' | '.join(map(str, counts))} |")
    return "\n".join([*lines, ""])


def section(title: str, run: dict[str, Any]) -> str:
    """The rows of one area, a table for each experiment."""
    lines = [f"## {run['area']}", "", title, ""]
    lines += [f"Commit {run['commit']}, seed {run['seed']}, on {run['machine']}.", ""]
    for experiment in dict.fromkeys(row["experiment"] for row in run["rows"]):
        rows = [row for row in run["rows"] if row["experiment"] == experiment]
        lines += [f"**{experiment}**, {rows[0]['cases']} cases", ""]
        lines += ["| | | figure | target | 95 % | would catch |", "|---|---|---|---|---|---|"]
        lines += [line(row) for row in rows] + [""]
    return "\n".join(lines)


def line(row: dict[str, Any]) -> str:
    """One row; what misses its target stands out."""
    status = row["status"] if row["status"] in ("pass", "info") else f"**{row['status']}**"
    figure = f"{row['figure']} ({row['why']})" if row["status"] == "known miss" else row["figure"]
    cells = [status, row["row"], figure, row["target"], row["interval"], row["power"]]
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"
