"""Runs: agents of every kind, bad ones too; the same results for any number of workers."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from threewe import ConfigError, active_target, available_targets
from threewe.benchmark.agents import identify
from threewe.benchmark.attempt import Settings
from threewe.benchmark.bundle import text_of
from threewe.benchmark.quick import run_quick
from threewe.benchmark.report import report
from threewe.benchmark.results import compare, load_results
from threewe.benchmark.run import commit_of, plan_run, results_of, run
from threewe.benchmark.tasks import soft_spl

from verify.cases.benchmarks import on_targets

ROOT = Path(__file__).resolve().parents[3]
THREEWE = str(Path(sys.executable).parent / "threewe")


def drive(folder: Path, agent: str, *, task: str = "pointnav", scene: str = "apartment_v1", episodes: int = 1,
          **how: Any) -> dict[str, Any]:  # fmt: skip
    plan, listed = plan_run(task, agent, split="val", scenes=[scene], episodes=episodes, settings=Settings())
    return results_of(plan, listed, run(plan, listed, folder / f"{Path(agent).stem}.jsonl", **how))


@pytest.mark.parametrize(
    ("agent", "why"),
    [
        ("Raises", r"ValueError: no way to \("),
        ("GivesUp", "TimeoutError"),
        ("ClearsTheScreen", r"^ValueError: \?\[2Jgone$"),
        ("PeeksAtTheTruth", "AttributeError: 'NoneType' object has no attribute 'true_pose'"),
        ("NotANumber", "action"),
        ("WrongShape", r"action must have shape \(3,\), got \(2,\)"),
    ],
)
def test_an_agent_that_fails_costs_its_episode_and_is_named(agent: str, why: str, tmp_path: Path) -> None:
    results = drive(tmp_path, f"benchmark.bad_agents:{agent}", workers=0)
    [row] = results["episode_results"]
    assert row["end"] == "failure"
    assert re.search(why, row["failure"])
    assert results["summary"]["all"]["agent_failures"]["value"] == 1
    assert row["metrics"]["success"] == 0.0
    assert row["ticks"] > 0


@pytest.mark.parametrize(
    ("agent", "why", "how"),
    [
        ("Hangs", "took longer than 4 s", {"limit": 4.0}),
        ("WaitsForTheWall", "", {}),
        ("EatsMemory", "used too much memory", {}),
        ("Dies", "its process died with status 7", {}),
    ],
)
def test_an_agent_that_takes_its_process_along_costs_its_episode(
    agent: str, why: str, how: dict[str, Any], tmp_path: Path
) -> None:
    results = drive(tmp_path, f"benchmark.bad_agents:{agent}", workers=1, **how)
    [row] = results["episode_results"]
    assert row["failure"] == why
    assert row["metrics"]["success"] == 0.0
    assert row["end"] == ("failure" if why else "time")


def test_an_agent_that_fails_in_one_episode_costs_that_one_alone(tmp_path: Path) -> None:
    agent, others = "benchmark.bad_agents:RaisesFarAway", drive(tmp_path, "navigator", episodes=3, workers=0)
    results = drive(tmp_path, agent, episodes=3, workers=2)
    rows = results["episode_results"]
    [(failed, lost)] = [(row, i) for i, row in enumerate(rows) if row["failure"]]
    assert (failed["end"], failed["failure"], failed["metrics"]["success"]) == (
        "failure",
        "ValueError: too far for me",
        0.0,
    )
    assert failed["ticks"] > 10
    for i, (row, other) in enumerate(zip(rows, others["episode_results"], strict=True)):
        assert (row == other) == (i != lost), i
    figures = results["summary"]["all"]
    assert figures["agent_failures"] == {"value": 1, "low": 1, "high": 1, "count": 3}
    assert figures["success"]["value"] == 2 / 3
    page = report(results)
    assert "in 1 scene, the agent failed in 1<" in page
    [data] = re.findall(r'<script id="data" type="application/json">(.*?)</script>', page, re.S)
    shown = {one["index"]: one["failure"] for one in json.loads(data)["scenes"][0]["episodes"]}
    assert shown == {row["episode"]["index"]: row["failure"] for row in rows}
    assert agent in page


def test_an_agent_that_fails_is_named_by_the_command(tmp_path: Path) -> None:
    run = [THREEWE, "benchmark", "run", "pointnav", "--scene", "apartment_v1", "--episodes", "3", "-o", "r.json"]
    shutil.copy(ROOT / "tests/python/benchmark/bad_agents.py", tmp_path / "mine.py")
    done = subprocess.run([*run, "--agent", "mine:RaisesFarAway"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    [row] = [row for row in load_results(tmp_path / "r.json")["episode_results"] if row["failure"]]
    line = f"apartment_v1/{row['episode']['index']}: the agent failed: ValueError: too far for me"
    assert done.stdout.startswith(f"{line}\n")
    assert done.stdout.count("the agent failed") == 1
    shown = subprocess.run([THREEWE, "benchmark", "show", "r.json", "--html", "r.html"], cwd=tmp_path)
    assert shown.returncode == 0
    assert "ValueError: too far for me" in (tmp_path / "r.html").read_text()


def test_results_name_all_that_they_came_of(tmp_path: Path) -> None:
    for backend in ("mock", "mujoco"):
        settings = Settings(backend=backend, randomization="hard")
        plan, listed = plan_run(
            "pointnav", "straight", split="val", episodes=1, scenes=["apartment_v1"], settings=settings
        )
        results = results_of(plan, listed, run(plan, listed, tmp_path / f"{backend}.jsonl", workers=0))
        assert results["agent"]["name"] == "straight"
        assert {name: results["settings"][name] for name in ("backend", "randomization", "hardware", "noise")} == {
            "backend": backend,
            "randomization": "hard",
            "hardware": "3we_standard_v2",
            "noise": "realistic",
        }
        assert results["settings"]["seed"] == 0
        assert results["episode_results"][0]["episode"]["seed"] == listed[0].seed
        assert len(results["hardware_hash"]) == 64
        assert (results["track"], results["gate"], results["localization"]) == ("open", "full", "the robot's own")
        assert ("mujoco" in results["library"]) == (backend == "mujoco")
        assert {"version", "commit", "machine"} <= set(results["library"])


def test_stop_far_from_the_goal_is_wrong(tmp_path: Path) -> None:
    results = drive(tmp_path, "benchmark.bad_agents:StandsStill", workers=0)
    [row] = results["episode_results"]
    assert (row["end"], row["failure"], row["metrics"]["success"]) == ("stop", "", 0.0)
    assert row["metrics"]["duration"] < 2.0


def test_results_are_the_same_for_any_number_of_workers(tmp_path: Path) -> None:
    together, alone = (drive(tmp_path / str(workers), "navigator", episodes=3, workers=workers) for workers in (2, 0))
    assert text_of(together) == text_of(alone)


def test_workers_that_are_killed_on_the_way_cost_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    agent = "benchmark.bad_agents:IsKilledOnce"
    killed = drive(tmp_path / "killed", agent, episodes=3, workers=2)
    assert len(list(tmp_path.glob("killed *"))) == 3, "each episode lost its process on the way"
    assert [row["end"] for row in killed["episode_results"]] == ["stop"] * 3
    for workers in (0, 1, 2):  # none is killed again
        undisturbed = drive(tmp_path / str(workers), agent, episodes=3, workers=workers)
        assert text_of(undisturbed) == text_of(killed), workers
    [journal] = (tmp_path / "killed").glob("*.jsonl")
    keys = [json.loads(line)["key"] for line in journal.read_text().splitlines()[1:]]
    assert len(keys) == len(set(keys)) == 3, "nothing twice, nothing lost"


def test_an_oracle_is_marked_and_a_yardstick_drives_no_robot(tmp_path: Path) -> None:
    oracle = drive(tmp_path, "oracle", workers=0)
    assert (oracle["agent"]["privileged"], oracle["official"]) == (True, False)
    assert oracle["summary"]["all"]["spl"]["value"] > 0.85
    best = drive(tmp_path, "optimistic", workers=0)
    assert not best["official"]
    assert best["summary"]["all"]["success"]["value"] == 1.0


def test_an_oracle_explores_with_the_true_pose(tmp_path: Path) -> None:
    oracle = drive(tmp_path, "oracle", task="exploration", workers=0)
    assert oracle["agent"]["privileged"]
    figures = oracle["summary"]["all"]
    assert figures["coverage"]["value"] > 0.9, "a given map would leave nothing to explore"
    assert figures["map_accuracy"]["value"] > 0.9


@pytest.mark.parametrize(
    ("agent", "message"),
    [
        ("navigater", "did you mean 'navigator'"),
        ("benchmark.bad_agents:Nothing", "has no attribute 'Nothing'"),
        ("no_such_module:Agent", "No module named"),
        ("benchmark.bad_agents:DoesNothing", "expected a method"),
        ("benchmark.bad_agents:NoCoroutine", "async def run"),
        ("none.onnx", "no such file"),
        ("benchmark.bad_agents:WantsTheTruth", "unknown option 'localization'"),
        ("benchmark.bad_agents:CannotBeMade", "cannot be made: ValueError: no weights"),
    ],
)
def test_agents_that_cannot_be_made_are_refused_before_the_run(agent: str, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        identify("pointnav", agent)


def test_paired_differences(tmp_path: Path) -> None:
    one, other = (drive(tmp_path, agent, episodes=2, workers=0) for agent in ("optimistic", "straight"))
    figures = compare(one, other)
    assert figures["success"]["value"] == -0.5
    assert figures["success"]["count"] == 2
    with pytest.raises(ConfigError, match="different tasks"):
        compare(one, {**other, "task": "exploration"})


def test_soft_spl_as_published() -> None:
    assert soft_spl(0.0, 4.0, 5.0) == pytest.approx(0.8)
    assert soft_spl(2.0, 4.0, 2.0) == pytest.approx(0.5)
    assert soft_spl(6.0, 4.0, 2.0) == 0.0


def test_bundles_are_the_same_bytes_on_every_vector_target() -> None:
    found = on_targets(1, "pointnav", "navigator")
    assert {"SCALAR", *available_targets()} == {*found["targets"]}
    assert found["equal"]
    assert active_target() == available_targets()[0]


def test_a_wheel_names_the_commit_that_it_was_made_from(tmp_path: Path) -> None:
    package = tmp_path / "site-packages/threewe"
    assert commit_of(package) == ""
    options = [f"-DSOURCE={ROOT}", f"-DFILE={package}/commit.txt"]
    subprocess.run(["cmake", *options, "-P", ROOT / "cmake/commit.cmake"], check=True)
    assert re.fullmatch("[0-9a-f]{10}(-dirty)?", commit_of(package))
    assert commit_of(package) == commit_of(ROOT / "python/threewe")


def test_the_command_goes_on_where_it_was_interrupted(tmp_path: Path) -> None:
    command = [THREEWE, "benchmark", "run", "pointnav", "--scene", "apartment_v1", "--episodes", "6", "-o", "r.json"]
    journal = tmp_path / "r.journal.jsonl"
    running = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not journal.exists() or journal.read_text().count("\n") < 3:
        assert running.poll() is None
        time.sleep(0.01)
    os.kill(running.pid, signal.SIGINT)
    out, _ = running.communicate()
    if running.returncode != 0:  # it may have been done by then
        assert running.returncode == 130
        assert "--resume goes on" in out
        assert not (tmp_path / "r.json").exists()
        again = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert again.returncode == 2
        assert "an interrupted run" in again.stderr
        done = subprocess.run([*command, "--resume"], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    assert not journal.exists()
    results = load_results(tmp_path / "r.json")
    assert results == json.loads(text_of(drive(tmp_path, "navigator", episodes=6, workers=0)))
    shown = subprocess.run([THREEWE, "benchmark", "show", "r.json"], cwd=tmp_path, capture_output=True, text=True)
    assert "pointnav, navigator" in shown.stdout


def test_the_command_goes_on_when_all_its_workers_are_killed(tmp_path: Path) -> None:
    command = [THREEWE, "benchmark", "run", "pointnav", "--scene", "apartment_v1", "--episodes", "6", "--workers", "2"]
    journal = tmp_path / "r.journal.jsonl"
    running = subprocess.Popen([*command, "-o", "r.json"], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    while not journal.exists() or journal.read_text().count("\n") < 2:
        assert running.poll() is None
        time.sleep(0.01)
    killed = [process for process in children_of(running.pid) if b"spawn_main" in commandline(process)]
    for process in killed:
        os.kill(process, signal.SIGKILL)
    assert len(killed) == 2
    _, error = running.communicate()
    assert running.returncode == 0, error
    assert load_results(tmp_path / "r.json") == json.loads(text_of(drive(tmp_path, "navigator", episodes=6, workers=0)))


def children_of(process: int) -> list[int]:
    listed = [file.read_text() for file in Path(f"/proc/{process}/task").glob("*/children")]
    return [int(child) for child in " ".join(listed).split()]


def commandline(process: int) -> bytes:
    return Path(f"/proc/{process}/cmdline").read_bytes()


def test_an_onnx_policy_drives_with_memory_and_stops_at_its_goal(tmp_path: Path) -> None:
    onnx = pytest.importorskip("onnx")
    pytest.importorskip("onnxruntime")
    helper, kind = onnx.helper, onnx.TensorProto.FLOAT
    action = helper.make_tensor("weights", kind, (2, 3), [0.5, 0.0, 0.0, 0.0, 0.5, 1.0])
    one = helper.make_tensor("one", kind, (1, 1), [1.0])
    graph = helper.make_graph(
        [
            helper.make_node("MatMul", ["goal", "weights"], ["wanted"]),
            helper.make_node("Clip", ["wanted", "low", "high"], ["action"]),
            helper.make_node("Add", ["steps", "one"], ["next_steps"]),
        ],
        "towards",
        [helper.make_tensor_value_info(name, kind, shape)
         for name, shape in {"goal": ["n", 2], "steps": ["n", 1], "lidar": ["n", 72]}.items()],
        [helper.make_tensor_value_info(name, kind, shape)
         for name, shape in {"action": ["n", 3], "next_steps": ["n", 1]}.items()],
        [action, one, helper.make_tensor("low", kind, (), [-1.0]), helper.make_tensor("high", kind, (), [1.0])],
    )  # fmt: skip
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=10)
    onnx.save(model, tmp_path / "towards.onnx")
    results = drive(tmp_path, str(tmp_path / "towards.onnx"), workers=0)
    assert (results["agent"]["kind"], results["agent"]["privileged"]) == ("act", False)
    assert len(results["agent"]["source"]) == 64
    [row] = results["episode_results"]
    assert (row["end"], row["failure"], row["metrics"]["success"]) == ("stop", "", 1.0)


def test_quick_runs_are_marked_and_much_alike(tmp_path: Path) -> None:
    plan, listed = plan_run(
        "pointnav", "straight", split="val", scenes=["apartment_v1"], episodes=4, settings=Settings()
    )
    plan = replace(plan, quick=True)
    results = results_of(plan, listed, run_quick(plan, listed))
    assert (results["quick"], results["official"]) == (True, False)
    slow = drive(tmp_path, "straight", episodes=4, workers=0)
    for row, other in zip(results["episode_results"], slow["episode_results"], strict=True):
        assert sorted(row["metrics"]) == sorted(other["metrics"])
        assert row["metrics"]["success"] == other["metrics"]["success"]
    with pytest.raises(ConfigError, match="for agents that act"):
        run_quick(plan_run("pointnav", "navigator", split="val", scenes=[], episodes=1, settings=Settings())[0], [])
