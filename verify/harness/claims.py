"""The published claims: results of full runs, a file for each area, and the page docs/claims.md made of them."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from verify.cases.trees import ROOT
from verify.harness.journal import Revision, machine
from verify.harness.rows import Row, Verdict
from verify.harness.running import Experiment

RESULTS = ROOT / "verify/results"
MEANINGS = ROOT / "verify/meanings.yaml"
PAGE = ROOT / "docs/claims.md"
STATUSES = ("pass", "FAIL", "known miss", "info", "not shown", "not run", "outdated")
HEAD = """\
# Claims

What 3we does, as `./dev verify` measured it: every claim with its figure, misses included. Cases are drawn from a seed
that follows from the commit, so nothing was tuned on them.

## What the misses mean for you

A **FAIL** misses its target, or it broke. A known miss misses its target too; its reason stands in the table below.
"""
SUMMARY = """\
## All claims

*95 %* is the interval of the figure; *would catch* is the drop that a run like this one catches nine times in ten.
*Not run* is a claim without a result on file; *outdated* is a result of a claim that has changed since. How rows are
judged: [verify](../verify/README.md). `./dev verify claims` makes this page of the files in `verify/results`.
"""

Shown = dict[str, str]
"""A row as the page has it: row, status, figure, target, interval and power, and `why` where it is a known miss."""


@dataclass(frozen=True)
class Area:
    """One of the programs of `verify`."""

    title: str  # in a line
    experiments: list[Experiment]


def save(area: str, experiment: Experiment, revision: Revision, seed: int, judged: list[tuple[Row, Verdict]]) -> None:
    """Writes what a full run of one experiment came to, in place of what was on file of it."""
    rows = [
        {
            "row": row.name,
            "status": verdict.status,
            "figure": verdict.figure,
            "target": verdict.target,
            "interval": verdict.interval,
            "power": verdict.power,
        }
        for row, verdict in judged
    ]
    run = {"commit": revision.commit, "seed": seed, "machine": machine(), "cases": experiment.cases, "rows": rows}
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / f"{area}.json"
    path.write_text(json.dumps(runs_of(area, RESULTS) | {experiment.name: run}, indent=1) + "\n")


def page(areas: Mapping[str, Area], results: Path = RESULTS, meanings: Path = MEANINGS) -> str:
    """The page: what misses mean, and of each area what is on file of its experiments."""
    runs = {name: runs_of(name, results) for name in areas}
    rows = {name: rows_of(area, runs[name]) for name, area in areas.items()}
    parts = [HEAD, *explained(misses(rows), yaml.safe_load(meanings.read_text())), SUMMARY, summary(areas, runs, rows)]
    parts += [section(name, area, runs[name], rows[name]) for name, area in areas.items() if runs[name]]
    return "\n".join(parts)


def runs_of(area: str, results: Path = RESULTS) -> dict[str, Any]:
    """What is on file of an area, by experiment."""
    file = results / f"{area}.json"
    runs: dict[str, Any] = json.loads(file.read_text()) if file.exists() else {}
    return runs


def rows_of(area: Area, runs: Mapping[str, Any]) -> dict[str, list[Shown]]:
    """Of each experiment the rows that the code has, with what is on file of them, then those that only files have."""
    claimed = {one.name: one.rows for one in area.experiments}
    shown: dict[str, list[Shown]] = {}
    for name in dict.fromkeys([*claimed, *runs]):
        on_file = {row["row"]: row for row in runs[name]["rows"]} if name in runs else {}
        shown[name] = []
        for row in claimed.get(name, []):
            same = row.name in on_file and (row.test is None or on_file[row.name]["target"] == row.target)
            shown[name].append(as_now(on_file.pop(row.name), row) if same else not_run(row))
        shown[name] += [{**row, "status": "outdated"} for row in on_file.values()]
    return shown


def misses(rows: Mapping[str, Mapping[str, list[Shown]]]) -> dict[str, str]:
    """Each FAIL and known miss of the page, as "area: experiment: row", and which of the two it is."""
    return {
        f"{area}: {experiment}: {row['row']}": row["status"]
        for area, experiments in rows.items()
        for experiment, shown in experiments.items()
        for row in shown
        if row["status"] in ("FAIL", "known miss")
    }


def as_now(found: Shown, row: Row) -> Shown:
    """A row on file. It is a known miss where the code has an excuse for it, whose bar lies in its interval."""
    if found["status"] not in ("FAIL", "known miss"):
        return found
    if row.known_miss and found["interval"]:
        low, high = map(number, found["interval"].strip("[]").split(", "))
        if low <= row.known_miss.bar <= high:
            return {**found, "status": "known miss", "why": row.known_miss.why}
    return {**found, "status": "FAIL"}


def not_run(row: Row) -> Shown:
    """A row without a result on file."""
    return {"row": row.name, "status": "not run", "figure": "", "target": row.target, "interval": "", "power": ""}


def number(shown: str) -> float:
    """A number of a figure, an interval or a target."""
    return 0.01 * float(shown[:-1]) if shown.endswith("%") else float(shown)


def explained(missed: Mapping[str, str], topics: list[dict[str, Any]]) -> Iterator[str]:
    """What misses mean for users, by what they want to do; those of which no meaning is written are named."""
    left = dict(missed)
    for topic in topics:
        lines = []
        for meaning in topic["misses"]:
            rows = [key for key in left if key.startswith(tuple(meaning["rows"]))]
            if rows:
                status = "**FAIL**" if "FAIL" in [left.pop(key) for key in rows] else "known miss"
                links = ", ".join(f"[{area}](#{area})" for area in dict.fromkeys(key.split(":")[0] for key in rows))
                lines.append(f"- {meaning['means'].strip()} ({status}, {links})")
        if lines:
            yield "\n".join([f"### {topic['topic']}", "", *lines, ""])
    if left:
        yield "\n".join(["### Not explained yet", "", *(f"- {key} ({status})" for key, status in left.items()), ""])


def summary(areas: Mapping[str, Area], runs: Mapping[str, Any], rows: Mapping[str, Mapping[str, list[Shown]]]) -> str:
    """A line for each area, also for those of which no full run is on file."""
    lines = [f"| area | {' | '.join(STATUSES)} | on file |", "|---" * (len(STATUSES) + 2) + "|"]
    for name, area in areas.items():
        statuses = [row["status"] for shown in rows[name].values() for row in shown]
        counts = " | ".join(str(statuses.count(status)) for status in STATUSES)
        on_file = sum(one.name in runs[name] for one in area.experiments)
        link = f"[{name}](#{name})" if runs[name] else name
        lines.append(f"| {link} | {counts} | {on_file} of {len(area.experiments)} experiments |")
    return "\n".join([*lines, ""])


def section(name: str, area: Area, runs: Mapping[str, Any], rows: Mapping[str, list[Shown]]) -> str:
    """The rows of one area, a table for each experiment."""
    lines = [f"## {name}", "", area.title, ""]
    for experiment, shown in rows.items():
        if experiment not in runs:
            lines += [f"**{experiment}**: no full run on file", ""]
            continue
        run = runs[experiment]
        of = f"{run['cases']} cases, commit {run['commit']}, seed {run['seed']}, on {run['machine']}"
        lines += [f"**{experiment}**: {of}", ""]
        lines += ["| | | figure | target | 95 % | would catch |", "|---|---|---|---|---|---|"]
        lines += [line(row) for row in shown] + [""]
    return "\n".join(lines)


def line(row: Shown) -> str:
    """One row; what misses its target stands out."""
    status = row["status"] if row["status"] in ("pass", "info") else f"**{row['status']}**"
    figure = f"{row['figure']} ({row['why']})" if "why" in row else row["figure"]
    cells = [status, row["row"], figure, row["target"], row["interval"], row["power"]]
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"
