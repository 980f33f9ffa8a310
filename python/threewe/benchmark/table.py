"""Page of several results as Markdown: agents of each task next to one another, with intervals."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from threewe.benchmark.episodes import load_episodes
from threewe.benchmark.results import Figure, load_results
from threewe.benchmark.tasks import NAMES, TASKS, TITLES
from threewe.errors import ConfigError

Run = tuple[Path, dict[str, Any]]
BY_SCENE = {
    "pointnav": ("success", "spl"),
    "objectnav": ("success", "spl"),
    "vln": ("success", "spl"),
    "exploration": ("coverage", "cell_ratio"),
}
HEAD = """\
# Benchmark results

Agents that come with 3we on the frozen episodes of [the benchmark](how-to-benchmark.md), misses included. Each cell is
a mean with its 95 % interval: Wilson's for rates, bootstrap for the rest. *Privileged* agents know what no robot does,
and are never official; a *baseline* drives no robot. Every figure follows from the files that the rows link to;
`threewe benchmark table` makes this page of them.
"""


def find_results(paths: Sequence[Path]) -> list[Run]:
    """Results of files, and of all .json files in folders. Raises ConfigError where there are none, or two alike."""
    files = [file for path in paths for file in (sorted(path.glob("*.json")) if path.is_dir() else [path])]
    if not files:
        raise ConfigError(f"results: no .json file in {', '.join(map(str, paths))}")
    runs = [(file, load_results(file)) for file in files]
    seen: dict[tuple[str, ...], Path] = {}
    for file, results in runs:
        key = (results["task"], results["agent"]["name"], results["episode_set"], results["settings"]["backend"])
        if key in seen:
            raise ConfigError(f"{file}: of the same agent and episodes as {seen[key]}")
        seen[key] = file
    return runs


def page(runs: Sequence[Run], folder: Path) -> str:
    """The page; `folder` is where it will lie, for its links."""
    parts = [HEAD]
    for task in NAMES:
        sets = dict.fromkeys(results["episode_set"] for _, results in runs if results["task"] == task)
        for name in sets:
            some = [run for run in runs if (run[1]["task"], run[1]["episode_set"]) == (task, name)]
            parts.append(_section(task, name, some, folder))
    return "\n".join(parts)


def _section(task: str, episode_set: str, runs: Sequence[Run], folder: Path) -> str:
    scenes = list(dict.fromkeys(scene for _, results in runs for scene in results["scenes"]))
    headline = TASKS[task].headline
    runs = sorted(runs, key=lambda run: (-run[1]["summary"]["all"][headline]["value"], run[1]["agent"]["name"]))
    counts = sorted({results["episodes"] for _, results in runs})
    names = [name for name in TITLES if name in (*TASKS[task].rates, *TASKS[task].means)]
    rows = [
        [_agent(file, results, folder), _count(results), *(_cell(results["summary"]["all"][name]) for name in names)]
        for file, results in runs
    ]
    first = " or ".join(map(str, counts))
    where = f"{len(scenes)} scene{'s' * (len(scenes) != 1)}"
    split = _split(task, episode_set)
    title = NAMES[task] if split == "test" else f"{NAMES[task]}, {split}"
    lines = [f"## {title}", "", f"The first {first} episodes of `{episode_set}` in each of {where}.", ""]
    lines += _table(["agent", "n", *(TITLES[name] for name in names)], rows)
    for name in BY_SCENE[task]:
        rows = [
            [results["agent"]["name"], *(_of_scene(results, scene, name) for scene in scenes)] for _, results in runs
        ]
        lines += ["", f"{TITLES[name]} by scene:", "", *_table(["agent", *scenes], rows)]
    return "\n".join([*lines, "", *_commands(runs), ""])


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]


def _agent(file: Path, results: dict[str, Any], folder: Path) -> str:
    agent = results["agent"]
    marks = ["privileged"] * agent["privileged"] + ["baseline"] * (agent["kind"] == "yardstick")
    marks += ["not official"] * (not results["official"] and agent["kind"] != "yardstick")
    link = Path(os.path.relpath(file, folder)).as_posix()
    return f"[{agent['name']}]({link}){''.join(f', *{mark}*' for mark in marks)}"


def _count(results: dict[str, Any]) -> str:
    return str(len(results["episode_results"]))


def _of_scene(results: dict[str, Any], scene: str, name: str) -> str:
    figures = results["summary"].get(scene)
    return _cell(figures[name]) if figures else "none"


def _cell(figure: Figure) -> str:
    digits = 0 if figure["value"] >= 10.0 else 2
    value, low, high = (f"{figure[key]:.{digits}f}" for key in ("value", "low", "high"))
    return f"{value}<br><small>[{low},&nbsp;{high}]</small>"


def _commands(runs: Sequence[Run]) -> list[str]:
    """What repeats them."""
    lines = [_command(results) for _, results in runs]
    library = {
        (run[1]["library"]["version"], run[1]["library"]["commit"], run[1]["library"]["machine"]) for run in runs
    }
    of = "; ".join(f"threewe {version}, commit {commit}, on {machine}" for version, commit, machine in sorted(library))
    return [f"Run with {of}:", "", "<!-- not run: takes minutes -->", "```console", *lines, "```"]


def _command(results: dict[str, Any]) -> str:
    task, episode_set = results["task"], results["episode_set"]
    try:
        known = list(dict.fromkeys(episode.scene for episode in load_episodes(episode_set)["episodes"]))
    except ConfigError:  # a set that is not at hand
        known = []
    scenes = "" if results["scenes"] == known else "".join(f" --scene {scene}" for scene in results["scenes"])
    agent = f"--agent {shlex.quote(results['agent']['name'])}"
    split = _split(task, episode_set)
    return f"$ threewe benchmark run {task} {agent} --split {split} --episodes {results['episodes']}{scenes} --compact"


def _split(task: str, episode_set: str) -> str:
    """As `--split` takes it."""
    split = episode_set.removeprefix(f"{task}_").removesuffix("_v1")
    return split if f"{task}_{split}_v1" == episode_set else episode_set
