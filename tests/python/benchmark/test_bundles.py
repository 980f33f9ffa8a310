"""Genuine bundles replay to the bit; forged ones are refused with the reason."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from threewe.benchmark import bundle as bundles
from threewe.benchmark.attempt import Settings
from threewe.benchmark.bundle import BundleError, read_bundle, write_bundle
from threewe.benchmark.episodes import to_json
from threewe.benchmark.run import plan_run, results_of, run
from threewe.benchmark.sampling import COLUMNS, make_episodes
from threewe.benchmark.verifying import rerun_policy, verify_bundle

from verify.cases.forgeries import (
    WAYS,
    Forger,
    agent_of_no_kind,
    other_actions,
    other_source,
    unmarked_privilege,
)


def run_here(
    folder: Path, task: str, agent: str, scene: str, episodes: int, backend: str = "mock"
) -> tuple[dict[str, Any], list[Any]]:
    """Results and outcomes, without a process of their own."""
    settings = Settings(backend=backend)
    plan, listed = plan_run(task, agent, split="val", scenes=[scene], episodes=episodes, settings=settings)
    outcomes = run(plan, listed, folder / "journal.jsonl", workers=0)
    return results_of(plan, listed, outcomes), outcomes


@pytest.fixture(scope="module")
def genuine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("genuine")
    write_bundle(folder / "run.zip", *run_here(folder, "pointnav", "navigator", "apartment_v1", 2))
    return folder / "run.zip"


def test_a_genuine_bundle_passes_and_is_the_same_again(genuine: Path, tmp_path: Path) -> None:
    verified = verify_bundle(genuine, workers=0)
    assert verified.plan.agent.name == "navigator"
    assert verified.results["summary"]["all"]["success"]["value"] == 1.0
    write_bundle(tmp_path / "again.zip", *run_here(tmp_path, "pointnav", "navigator", "apartment_v1", 2))
    assert (tmp_path / "again.zip").read_bytes() == genuine.read_bytes()


@pytest.mark.parametrize(
    ("task", "agent", "scene"),
    [("pointnav", "straight", "apartment_v1"), ("objectnav", "semantic", "cluttered_v1"),
     ("exploration", "navigator", "apartment_v1"), ("objectnav", "policy:goto_v1", "cluttered_v1"),
     ("pointnav", "benchmark.bad_agents:GivesUp", "apartment_v1")],
)  # fmt: skip
def test_bundles_of_every_task_and_kind_of_agent_pass(task: str, agent: str, scene: str, tmp_path: Path) -> None:
    write_bundle(tmp_path / "run.zip", *run_here(tmp_path, task, agent, scene, 1))
    verified = verify_bundle(tmp_path / "run.zip", workers=0)
    assert verified.results["agent"]["kind"] == ("act" if agent == "straight" else "run")
    assert verified.results["agent"]["privileged"] == (agent == "semantic")


def test_forged_bundles_are_refused_with_the_reason(genuine: Path, tmp_path: Path) -> None:
    path = tmp_path / "forged.zip"
    kinds: Counter[str] = Counter()
    for seed in range(3 * len(WAYS)):
        kind, content = Forger(genuine, seed).forged()
        path.write_bytes(content)
        with pytest.raises(BundleError) as refused:
            verify_bundle(path, workers=0)
        assert len(str(refused.value)) > 20, f"{kind}, seed {seed}: {refused.value}"
        kinds[kind] += 1
    assert len(kinds) > 0.8 * len(WAYS)


def test_an_agent_that_comes_with_3we_is_as_it_is_known(tmp_path: Path) -> None:
    write_bundle(tmp_path / "run.zip", *run_here(tmp_path, "pointnav", "oracle", "apartment_v1", 1))
    assert verify_bundle(tmp_path / "run.zip", workers=0).plan.agent.privileged
    for change in (unmarked_privilege, other_source, agent_of_no_kind):
        forger = Forger(tmp_path / "run.zip", 0)
        change(forger)
        (tmp_path / "forged.zip").write_bytes(forger.packed())
        with pytest.raises(BundleError, match="agent: "):
            verify_bundle(tmp_path / "forged.zip", workers=0)


def test_the_reason_says_where_a_log_differs_first(genuine: Path, tmp_path: Path) -> None:
    forger = Forger(genuine, 0)
    forger.results["episode_results"][1]["trajectory"][20][0] += 0.001
    (tmp_path / "forged.zip").write_bytes(forger.packed())
    with pytest.raises(BundleError, match=r"episode 1 \(apartment_v1/\d+\): differs from its replay at 4\.00 s"):
        verify_bundle(tmp_path / "forged.zip", workers=0)


def test_actions_are_those_of_the_drive(genuine: Path, tmp_path: Path) -> None:
    path = tmp_path / "run.zip"
    write_bundle(path, *run_here(tmp_path, "pointnav", "straight", "apartment_v1", 2))
    assert [row["end"] for row in read_bundle(path).results["episode_results"]] == ["stop", "time"]
    reasons = set()
    for seed in range(40):
        for bundle in (path, genuine):
            forger = Forger(bundle, seed)
            other_actions(forger)
            (tmp_path / "forged.zip").write_bytes(forger.packed())
            with pytest.raises(BundleError, match=r"^episode \d \(apartment_v1/\d+\): actions: ") as refused:
                verify_bundle(tmp_path / "forged.zip", workers=0)
            reasons.add(re.sub("[0-9.]+", "N", str(refused.value).partition("actions: ")[2]))
    assert reasons == {
        "missing",
        "of none that acts",
        "one is not finite",
        "N are not those of N s",
        "they do not say STOP as the claim does, 'stop'",
        "they do not say STOP as the claim does, 'time'",
    }


def test_every_bad_agent_that_acts_is_verified(tmp_path: Path) -> None:
    for agent in ("NotANumber", "WrongShape", "StandsStill"):
        made = run_here(tmp_path / agent, "pointnav", f"benchmark.bad_agents:{agent}", "apartment_v1", 1)
        write_bundle(tmp_path / "run.zip", *made)
        assert len(verify_bundle(tmp_path / "run.zip", workers=0).results["episode_results"]) == 1


def test_no_bundle_is_too_large(genuine: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bundles, "LARGEST", 10_000)
    with pytest.raises(BundleError, match="larger than 10000 bytes"):
        read_bundle(genuine)
    with pytest.raises(Exception, match="run fewer episodes"):
        write_bundle(tmp_path / "run.zip", *run_here(tmp_path, "pointnav", "navigator", "apartment_v1", 1))


def test_a_policy_is_run_again_in_buildings_that_its_seed_draws(genuine: Path, tmp_path: Path) -> None:
    verified = verify_bundle(genuine, workers=0)
    again = rerun_policy(verified, seed=3, episodes=2, workers=0, folder=tmp_path)
    assert len(again["episode_results"]) == 2
    assert again["summary"]["all"]["success"]["value"] == 1.0
    other = replace(verified, plan=replace(verified.plan, agent=replace(verified.plan.agent, source="0" * 64)))
    with pytest.raises(BundleError, match="another than in the bundle"):
        rerun_policy(other, seed=3, episodes=2, workers=0, folder=tmp_path)


def test_a_run_on_mujoco_replays_on_this_processor(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    write_bundle(tmp_path / "run.zip", *run_here(tmp_path, "pointnav", "navigator", "apartment_v1", 1, "mujoco"))
    verified = verify_bundle(tmp_path / "run.zip", workers=0)
    assert verified.results["repeats"] == "to the bit on one kind of processor"


def test_held_out_buildings_are_verified_with_the_set_that_its_holder_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("threewe.benchmark.sampling.BUILDINGS", 2)
    made = make_episodes("pointnav", "generated", secret="not to be known")
    file = tmp_path / "held_out.json"
    file.write_text(to_json(made, COLUMNS["pointnav"]))
    plan, listed = plan_run("pointnav", "navigator", split=str(file), scenes=[], episodes=1, settings=Settings())
    assert len(listed) == 2
    outcomes = run(plan, listed, tmp_path / "journal.jsonl", workers=0)
    write_bundle(tmp_path / "run.zip", results_of(plan, listed, outcomes), outcomes)
    assert len(verify_bundle(tmp_path / "run.zip", workers=0, episode_file=file).results["scenes"]) == 2
    with pytest.raises(BundleError, match="episode_set"):
        verify_bundle(tmp_path / "run.zip", workers=0)
    file.write_text(file.read_text().replace("straight", "detour"))
    with pytest.raises(BundleError, match="hash differs"):
        verify_bundle(tmp_path / "run.zip", workers=0, episode_file=file)
