"""The published page is what follows from the published results, and they are what follows from their episodes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import command_line
import pytest
from threewe import ConfigError
from threewe.benchmark import load_results, summarize
from threewe.benchmark.bundle import text_of
from threewe.benchmark.episodes import digest, find_episodes
from threewe.benchmark.report import report
from threewe.benchmark.table import find_results, page

ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "docs/benchmark-results.md"
RESULTS = ROOT / "docs/results"
PUBLISHED = {
    "pointnav": ["navigator", "oracle", "optimistic", "straight", "random"],
    "objectnav": ["semantic", "semantic-unseen", "detector", "random"],
    "vln": ["language"],
    "exploration": ["navigator", "oracle", "optimistic", "random"],
}
FILES = sorted(RESULTS.glob("*.json"))


def test_the_page_is_that_of_the_results() -> None:
    assert PAGE.read_text() == page(find_results([RESULTS]), PAGE.parent), (
        "run threewe benchmark table docs/results -o docs/benchmark-results.md"
    )


def test_every_agent_is_published() -> None:
    wanted = sorted(f"{task}-{agent}" for task, agents in PUBLISHED.items() for agent in agents)
    assert sorted(file.stem for file in FILES) == wanted


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_figures_follow_from_the_episodes(file: Path) -> None:
    results = load_results(file)
    task, agent, *split = file.stem.split("-")
    assert (results["task"], results["agent"]["name"]) == (task, agent)
    assert results["summary"] == json.loads(text_of(summarize(results["task"], results["episode_results"])))
    assert results["episode_set"] == f"{task}_{(split or ['test'])[0]}_v1", "what is published is of the split for that"
    assert results["episode_hash"] == digest(find_episodes(results["episode_set"]))
    assert len(results["episode_results"]) == results["episodes"] * len(results["scenes"])
    assert results["episodes"] >= 10
    assert results["official"] == (results["agent"]["kind"] != "yardstick" and not results["agent"]["privileged"])
    assert "dirty" not in results["library"]["commit"]
    assert not any(row["failure"] for row in results["episode_results"])


def some_results(agent: str = "navigator", task: str = "pointnav") -> dict[str, Any]:
    return load_results(RESULTS / f"{task}-{agent}.json")


def test_a_page_shows_who_knew_more_and_what_is_missing(tmp_path: Path) -> None:
    oracle, fewer = some_results("oracle"), some_results("straight")
    fewer["scenes"] = fewer["scenes"][:1]
    fewer["episode_results"] = [row for row in fewer["episode_results"] if row["episode"]["scene"] in fewer["scenes"]]
    fewer["summary"] = summarize("pointnav", fewer["episode_results"])
    fewer["official"] = False
    for name, results in {"a": oracle, "b": fewer}.items():
        (tmp_path / f"{name}.json").write_bytes(text_of(results))
    text = page(find_results([tmp_path]), tmp_path.parent)
    assert f"[oracle]({tmp_path.name}/a.json), *privileged*, *not official* |" in text
    assert f"[straight]({tmp_path.name}/b.json), *not official* |" in text
    assert text.index("[oracle]") < text.index("[straight]"), "the best first"
    assert "| straight | " in text
    assert " | none | none |" in text
    (tmp_path / "c.json").write_bytes(text_of(oracle))
    with pytest.raises(ConfigError, match=r"c\.json: of the same agent and episodes as .*a\.json"):
        find_results([tmp_path])
    (tmp_path / "empty").mkdir()
    with pytest.raises(ConfigError, match=r"no \.json file in"):
        find_results([tmp_path / "empty"])


def test_compact_results_have_all_but_trajectories(tmp_path: Path) -> None:
    run = ["benchmark", "run", "pointnav", "--agent", "straight", "--scene", "apartment_v1"]
    for options in (["--output", "whole.json"], ["--output", "small.json", "--compact", "--bundle", "run.zip"]):
        done = command_line.threewe(*run, "--episodes", "2", *options, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    whole, small = (load_results(tmp_path / f"{name}.json") for name in ("whole", "small"))
    assert all(row.pop("trajectory") for row in whole["episode_results"])
    assert small == whole
    assert all(row["trajectory"] for row in load_results(tmp_path / "run.zip")["episode_results"])
    with pytest.raises(ConfigError, match="run without --compact"):
        report(small)
    done = command_line.threewe("benchmark", "table", "small.json", cwd=tmp_path)
    assert done.stdout.startswith("# Benchmark results\n")
    assert "| [straight](small.json) | 2 | " in done.stdout
