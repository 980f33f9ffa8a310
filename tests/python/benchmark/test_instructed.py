"""Agents that are asked in words: the robot's own grammar and detector, and a model whose talk is in the bundle."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import pytest
from threewe import ConfigError, Zone
from threewe.benchmark.agents import identify
from threewe.benchmark.attempt import Settings
from threewe.benchmark.bundle import BundleError, pack, read_bundle, text_of, write_bundle
from threewe.benchmark.run import plan_run, results_of, run
from threewe.benchmark.tasks import Assignment
from threewe.benchmark.verifying import verify_bundle
from threewe.robot import Robot
from threewe.testing import ModelServer

SEARCH = {"skill": "rotate", "degrees": 40}
DONE = {"skill": "done", "answer": "Here."}


def run_here(folder: Path, task: str, agent: str, scene: str = "apartment_v1") -> tuple[dict[str, Any], list[Any]]:
    """Results and outcomes of an episode, without a process of their own."""
    plan, listed = plan_run(task, agent, split="val", scenes=[scene], episodes=1, settings=Settings())
    outcomes = run(plan, listed, folder / f"{task}.jsonl", workers=0)
    return results_of(plan, listed, outcomes), outcomes


@pytest.mark.parametrize(("task", "agent"), [("objectnav", "detector"), ("vln", "language")])
def test_agents_without_a_model_are_not_privileged_and_replay(task: str, agent: str, tmp_path: Path) -> None:
    results, outcomes = run_here(tmp_path, task, agent)
    assert results["official"]
    assert not results["agent"]["privileged"]
    assert results["localization"] == "the robot's own"
    [row] = results["episode_results"]
    assert (row["end"], row["failure"]) in (("stop", ""), ("time", ""))
    assert row["metrics"]["path_length"] > 1.0
    write_bundle(tmp_path / "run.zip", results, outcomes)
    assert len(verify_bundle(tmp_path / "run.zip", workers=0).results["episode_results"]) == 1
    with pytest.raises(BundleError, match="no conversation with a model is in the bundle"):
        verify_bundle(tmp_path / "run.zip", workers=0, talk=True)


def test_a_model_in_the_environment_is_not_asked_by_other_agents(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with ModelServer([]) as server:
        monkeypatch.setenv("THREEWE_MODEL", server.url)
        results, _ = run_here(tmp_path, "vln", "language")
        assert not server.requests
    assert not results["episode_results"][0]["failure"]


def test_a_conversation_is_in_the_bundle_and_repeats_the_drive(tmp_path: Path) -> None:
    for task in ("objectnav", "vln"):
        with ModelServer([SEARCH, {"skill": "move_forward", "distance": 0.2}, DONE]) as server:
            results, outcomes = run_here(tmp_path, task, f"vlm@{server.url}")
            name = results["agent"]["name"]
            assert name == f"vlm@{server.url}"
        path = tmp_path / "run.zip"
        write_bundle(path, results, outcomes)
        talk = read_bundle(path).part("talk", 0)
        assert talk is not None
        words = results["episode_results"][0]["episode"].get("instruction")
        assert json.loads(talk.splitlines()[0])["instruction"] == words or task == "objectnav"
        verify_bundle(path, workers=0, talk=True)  # its server is gone


def test_a_conversation_that_is_not_that_of_the_drive_is_refused(tmp_path: Path) -> None:
    with ModelServer([SEARCH, DONE]) as server:
        results, outcomes = run_here(tmp_path, "objectnav", f"vlm@{server.url}")
    path = tmp_path / "run.zip"
    talk = base64.b64decode(outcomes[0]["replayed"]["talk"]).decode()
    commands = base64.b64decode(outcomes[0]["replayed"]["commands"])
    for other, says in [
        (talk.replace('"degrees\\\\\\": 40', '"degrees\\\\\\": -40').replace('\\"degrees\\": 40', '\\"degrees\\": -40'),
         "given the same answers, the robot leaves the log at"),
        ("no JSON", "talk is no record of a conversation"),
    ]:  # fmt: skip
        files = {"results.json": text_of(results), "commands/00000.f64": commands, "talk/00000.jsonl": other.encode()}
        path.write_bytes(pack(files))
        with pytest.raises(BundleError, match=says):
            verify_bundle(path, workers=0, talk=True)


def test_a_model_that_fails_costs_its_episode(tmp_path: Path) -> None:
    with ModelServer([], faults="unauthorized") as server:
        results, outcomes = run_here(tmp_path, "objectnav", f"vlm@{server.url}")
    [row] = results["episode_results"]
    assert row["end"] == "failure"
    assert "401" in row["failure"]
    write_bundle(tmp_path / "run.zip", results, outcomes)
    verify_bundle(tmp_path / "run.zip", workers=0, talk=True)


def test_which_model_a_result_is_of_follows_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("THREEWE_MODEL", "http://127.0.0.1:8080/v1/#small")
    assert identify("vln", "vlm").name == "vlm@http://127.0.0.1:8080/v1#small"
    monkeypatch.delenv("THREEWE_MODEL")
    for task, name, says in [
        ("vln", "vlm", "vlm needs a model: vlm@http://127.0.0.1:8080/v1, or THREEWE_MODEL"),
        ("vln", "vlm@http://", "'http://' is no address"),
        ("vln", "detector", r"unknown agent of vln 'detector'.*language"),
        ("pointnav", "vlm@http://127.0.0.1:8080/v1", "vlm is for objectnav and vln, not for pointnav"),
    ]:
        with pytest.raises(ConfigError, match=says):
            identify(task, name)


class Acts:
    """An agent that acts."""

    def act(self, observation: Any) -> Any:
        """No action."""
        return observation


def test_routes_are_for_programs() -> None:
    with pytest.raises(ConfigError, match="VLN is for programs"):
        identify("vln", f"{__name__}:Acts")


class Notes:
    """Notes what it is given."""

    given: Assignment

    async def run(self, robot: Robot, assignment: Assignment) -> None:
        """Stands."""
        del robot
        Notes.given = assignment


def test_a_route_is_given_by_its_words_and_the_borders_of_rooms(tmp_path: Path) -> None:
    run_here(tmp_path, "vln", f"{__name__}:Notes")
    given = Notes.given
    assert given.goal is None
    assert given.instruction
    names = [name for name, _ in given.places]
    assert "kitchen" in names
    around = [name for name, border in given.places if Zone(border).contains((0.0, 0.0))]
    assert len(around) == 1, "the robot begins in one of them, at the origin of its map"
