"""Policies are judged by episodes in sight, and drive as agents of the benchmarks."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from ai import policies
from threewe import ConfigError
from threewe.ai import VLARunner
from threewe.ai.evaluating import Evaluation, evaluate, summarize
from threewe.benchmark.agents import identify
from threewe.benchmark.attempt import Settings
from threewe.benchmark.run import plan_run
from threewe.cli import app
from typer.testing import CliRunner


@pytest.fixture
def standing(tmp_path: Path) -> Path:
    """A policy that stands where it is."""
    return policies.write(tmp_path / "standing", policies.graph((0.0, 0.0, 0.0)))


def test_a_policy_that_stands_stops_at_once_and_fails(standing: Path) -> None:
    drives = evaluate(standing, Evaluation(count=1, backends=("mock",), seeds=(0, 1)))
    assert len(drives) == 12
    assert {drive.end for drive in drives} == {"stop"}
    assert not any(drive.success for drive in drives)
    figures = summarize(drives)["mock"]
    assert figures["all"]["count"] == 12
    assert figures["all"]["success"]["value"] == 0.0
    assert figures["all"]["success"]["high"] > 0.2
    assert figures["ends"] == {"stop": 12}
    assert figures["office_v2"]["count"] == 2
    assert {drive.episode.seed for drive in drives if drive.seed == 0}.isdisjoint(
        drive.episode.seed for drive in drives if drive.seed == 1
    )


def test_a_policy_goes_from_one_backend_to_the_other(tmp_path: Path) -> None:
    result = tmp_path / "transfer.json"
    how = ("--task", "objectnav", "--split", "in_sight_v1", "--scene", "warehouse_v1", "--seeds", "1")
    counts = ("--episodes", "2", "--target-episodes", "1")
    command = ["transfer", "run", "--policy", "policy:goto_v1", *how, *counts, "--output", str(result)]
    done = CliRunner().invoke(app, command, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    assert "SR on mock" in done.output
    assert "SR on mujoco" in done.output
    found = json.loads(result.read_text())["summary"]
    assert (found["source"]["count"], found["target"]["count"]) == (2, 1)
    assert found["source"]["value"] > 0  # it gets there, so that there is a ratio
    assert found["ratio"]["count"] == 1


def test_what_a_policy_fails_of_is_its_end(tmp_path: Path) -> None:
    broken = policies.write(tmp_path / "broken", policies.graph((3e38, 0.0, 0.0), red=3e38))
    (drive,) = evaluate(broken, Evaluation("generated", count=1))
    assert drive.end.startswith("NavigationError: policy_error")


def test_another_kind_is_named_only_where_one_is_in_sight(standing: Path) -> None:
    drives = evaluate(standing, Evaluation("generated", count=3, other=True))
    assert {drive.episode.stratum for drive in drives} == {"among others"}


def test_two_workers_find_what_none_does(standing: Path) -> None:
    what = Evaluation("generated", count=2, seeds=(3,))
    assert evaluate(standing, what, workers=2) == evaluate(standing, what)


def test_the_command_prints_and_writes_figures(standing: Path, tmp_path: Path) -> None:
    output = tmp_path / "figures.json"
    arguments = ["policy", "eval", str(standing), "--episodes", "generated", "--count", "2", "-o", str(output)]
    result = CliRunner().invoke(app, [*arguments, "--backend", "mock", "--backend", "mujoco"])
    assert result.exception is None
    assert "0.000" in result.output
    assert [*json.loads(output.read_text())] == ["mock", "mujoco"]


def test_the_shipped_policy_is_small_and_gets_there_the_same_way_twice() -> None:
    runner = VLARunner.from_pretrained("goto_v1")
    folder = runner.policy.folder
    assert sum(file.stat().st_size for file in folder.iterdir()) <= 2e6
    assert runner.policy.language
    drives = [evaluate("goto_v1", Evaluation("generated", count=3, seeds=(5,))) for _ in range(2)]
    assert drives[0] == drives[1]
    assert any(drive.success for drive in drives[0])


def test_a_policy_is_an_agent_of_objectnav(standing: Path) -> None:
    identity = identify("objectnav", f"policy:{standing}")
    assert (identity.kind, identity.privileged) == ("run", False)
    other = identify("objectnav", f"policy:{policies.write(standing.parent / 'other')}")
    assert identity.source != other.source
    plan, listed = plan_run(
        "objectnav", f"policy:{standing}", split="in_sight_v1", scenes=[], episodes=1, settings=Settings()
    )
    assert (plan.episode_set, len(listed)) == ("in_sight_v1", 6)
    with pytest.raises(ConfigError, match="its task is objectnav, not pointnav"):
        identify("pointnav", f"policy:{standing}")
    with pytest.raises(ConfigError, match="no such folder; a policy is a folder, or one of"):
        identify("objectnav", "policy:nowhere")


def test_episodes_that_a_policy_cannot_be_judged_by(standing: Path) -> None:
    with pytest.raises(ConfigError, match="reactive_v1 is of navigation, not of objectnav"):
        evaluate(standing, Evaluation("reactive_v1"))
    with pytest.raises(ConfigError, match="did you mean 'in_sight_v1'"):
        evaluate(standing, Evaluation("in_sight_v2"))
