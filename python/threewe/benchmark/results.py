"""Results of benchmark runs: reading, summaries with intervals, paired comparison."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from threewe._files import read_text
from threewe.benchmark.statistics import bootstrap, mean, wilson
from threewe.benchmark.tasks import TASKS
from threewe.errors import ConfigError

Figure = dict[str, Any]
"""`value` with its 95 % interval `low` to `high`, of `count` episodes."""


def summarize(task: str, rows: Sequence[dict[str, Any]]) -> dict[str, dict[str, Figure]]:
    """Every metric with its 95 % interval, of all episodes and of each scene: Wilson for rates, bootstrap else."""
    scenes = dict.fromkeys(row["episode"]["scene"] for row in rows)
    groups = {"all": list(rows)} | {
        scene: [row for row in rows if row["episode"]["scene"] == scene] for scene in scenes
    }
    return {name: _summary(task, some) for name, some in groups.items() if some}


def _summary(task: str, rows: Sequence[dict[str, Any]]) -> dict[str, Figure]:
    figures: dict[str, Figure] = {}
    for name in TASKS[task].rates:
        hits = sum(row["metrics"][name] > 0.5 for row in rows)
        low, high = wilson(hits, len(rows))
        figures[name] = {"value": hits / len(rows), "low": low, "high": high, "count": len(rows)}
    for name in TASKS[task].means:
        values = [row["metrics"][name] for row in rows]
        low, high = bootstrap(values)
        figures[name] = {"value": mean(values), "low": low, "high": high, "count": len(values)}
    failed = sum(bool(row["failure"]) for row in rows)
    figures["agent_failures"] = {"value": failed, "low": failed, "high": failed, "count": len(rows)}
    return figures


def load_results(path: str | Path) -> dict[str, Any]:
    """Results of a file, also those in a bundle. Raises ConfigError for what holds none."""
    path = Path(path)
    if path.suffix == ".zip":
        from threewe.benchmark.bundle import read_bundle

        return read_bundle(path).results
    try:
        results: Any = json.loads(read_text(path))
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"{path}: {error}") from None
    if not isinstance(results, dict) or results.get("format") != "threewe-benchmark/1":
        raise ConfigError(f"{path}: no results of `threewe benchmark run`")
    return dict(results)


def without_trajectories(results: dict[str, Any]) -> dict[str, Any]:
    """All figures, and not where the robots drove: a hundredth of the size, enough to compare and to publish."""
    rows = [{name: row[name] for name in row if name != "trajectory"} for row in results["episode_results"]]
    return {**results, "episode_results": rows}


def compare(a: dict[str, Any], b: dict[str, Any]) -> dict[str, Figure]:
    """Paired differences b - a over the episodes that both have, each with its 95 % bootstrap interval.

    Raises ConfigError where the tasks or sets of episodes differ, or no episode is in both.
    """
    for name in ("task", "episode_hash"):
        if a[name] != b[name]:
            raise ConfigError(f"results of different {name.replace('_hash', ' set')}s cannot be compared in pairs")
    rows = [
        {(row["episode"]["scene"], row["episode"]["index"]): row["metrics"] for row in some["episode_results"]}
        for some in (a, b)
    ]
    pairs = [(rows[0][key], rows[1][key]) for key in rows[0] if key in rows[1]]
    if not pairs:
        raise ConfigError("no episode is in both results")
    figures = {}
    for name in (*TASKS[a["task"]].rates, *TASKS[a["task"]].means):
        differences = [other[name] - one[name] for one, other in pairs]
        low, high = bootstrap(differences)
        figures[name] = {"value": mean(differences), "low": low, "high": high, "count": len(pairs)}
    return figures
