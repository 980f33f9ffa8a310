"""Jobs on a Ray cluster of a head and two nodes: nothing is lost, nothing counted twice, whatever is killed."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from threewe.benchmark.attempt import Settings
from threewe.benchmark.bundle import text_of
from threewe.benchmark.results import load_results
from threewe.benchmark.run import plan_run, results_of, run
from threewe.benchmark.runner import Job, Journal

if importlib.util.find_spec("ray") is None:
    pytest.skip("Ray is not installed", allow_module_level=True)

import ray
from ray.cluster_utils import Cluster
from threewe.benchmark.ray_engine import run_on_ray

THREEWE = Path(sys.executable).with_name("threewe")
pytestmark = pytest.mark.filterwarnings("ignore")  # warnings of Ray itself


def work(how: str, folder: str, number: int) -> dict[str, Any]:
    """Does it in that way, and says where."""
    if how == "raises":
        raise ValueError("boom")
    if how == "hangs":
        time.sleep(120.0)
    if how == "exits":
        os._exit(3)
    if how == "is killed once":
        mark = Path(folder, f"killed {number}")
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), 9)
    time.sleep(6.0 if how == "takes its time" else 0.2)
    return {"number": number}


@contextmanager
def connected(made: Any) -> Iterator[None]:
    """To a cluster whose workers find this module."""
    path = os.pathsep.join(str(folder) for folder in (Path(__file__).parents[1], Path(__file__).parents[3]))
    ray.init(address=made.address, log_to_driver=False, runtime_env={"env_vars": {"PYTHONPATH": path}})
    try:
        yield
    finally:
        ray.shutdown()


@contextmanager
def three_nodes() -> Iterator[tuple[Any, list[Any]]]:
    """A cluster, and the two nodes beside its head."""
    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    nodes = [made.add_node(num_cpus=1) for _ in range(2)]
    with connected(made):
        yield made, nodes
    made.shutdown()


@pytest.fixture(scope="module")
def shared_cluster(only_cluster: None) -> Iterator[tuple[Any, list[Any]]]:
    """The cluster of all tests that leave its nodes alone."""
    del only_cluster
    with three_nodes() as cluster:
        yield cluster


@pytest.fixture
def cluster(kill: bool, request: pytest.FixtureRequest) -> Iterator[tuple[Any, list[Any]]]:
    """One of its own for a test that kills a node."""
    if not kill:
        yield request.getfixturevalue("shared_cluster")
        return
    request.getfixturevalue("only_cluster")
    with three_nodes() as cluster:
        yield cluster


WITH_OR_WITHOUT_A_KILL = pytest.mark.parametrize("kill", [False, pytest.param(True, marks=pytest.mark.nightly)])


@WITH_OR_WITHOUT_A_KILL
def test_a_node_and_workers_that_are_killed_cost_nothing(
    cluster: tuple[Any, list[Any]], kill: bool, tmp_path: Path
) -> None:
    made, nodes = cluster
    ways = ["is killed once", "well", "is killed once", "well", "raises", "exits", "is killed once", *["well"] * 8]
    jobs = [Job(f"{i}", work, {"how": how, "folder": str(tmp_path), "number": i}, 100.0) for i, how in enumerate(ways)]
    jobs.append(Job("hangs", work, {"how": "hangs", "folder": str(tmp_path), "number": 99}, 8.0))
    told: list[str] = []

    def done(job: Job, _: Any) -> None:
        told.append(job.key)
        if kill and len(told) == 4:
            made.remove_node(nodes.pop(), allow_graceful=False)

    found = run_on_ray(jobs, 3, Journal(tmp_path / "journal.jsonl"), on_done=done)
    assert sorted(told) == sorted(job.key for job in jobs)
    for i, how in enumerate(ways):
        if how in ("well", "is killed once"):
            assert (found[i].result, found[i].failure) == ({"number": i}, "")
    assert "ValueError: boom" in found[4].failure
    assert found[5].failure.startswith("its process died")
    assert found[5].own
    assert found[-1].failure == "took longer than 8 s"
    keys = [json.loads(line)["key"] for line in (tmp_path / "journal.jsonl").read_text().splitlines()]
    assert sorted(keys) == sorted(job.key for job in jobs)


@pytest.mark.usefixtures("shared_cluster")
def test_a_job_that_waits_for_a_processor_does_not_hang(tmp_path: Path) -> None:
    arguments = {"how": "takes its time", "folder": str(tmp_path)}
    jobs = [Job(f"{i}", work, {**arguments, "number": i}, 10.0) for i in range(6)]  # three at a time, so 12 s in all
    found = run_on_ray(jobs, 6)
    assert [one.failure for one in found] == [""] * 6
    assert all(6.0 <= one.seconds < 10.0 for one in found)


@WITH_OR_WITHOUT_A_KILL
def test_results_are_those_of_one_process_whatever_is_killed(
    cluster: tuple[Any, list[Any]], kill: bool, tmp_path: Path
) -> None:
    made, nodes = cluster
    plan, listed = plan_run(
        "pointnav", "navigator", split="val", scenes=["apartment_v1"], episodes=8, settings=Settings()
    )
    alone = run(plan, listed, tmp_path / "local.jsonl", workers=0)

    def done(count: int, *_: Any) -> None:
        if kill and count == 2:  # when two others are under way
            made.remove_node(nodes.pop(), allow_graceful=False)

    on_ray = run(plan, listed, tmp_path / "ray.jsonl", workers=3, engine="ray", on_done=done)
    assert len(nodes) == (1 if kill else 2)
    assert text_of(results_of(plan, listed, alone)) == text_of(results_of(plan, listed, on_ray))


def test_the_command_loses_nothing_where_it_is_killed_itself(
    shared_cluster: tuple[Any, list[Any]], tmp_path: Path
) -> None:
    made, _ = shared_cluster
    command = [THREEWE, "benchmark", "run", "pointnav", "--scene", "apartment_v1", "--episodes", "6", "-o", "r.json"]
    on_ray = [*command, "--engine", "ray", "--address", made.address, "--workers", "2"]
    journal = tmp_path / "r.journal.jsonl"
    running = subprocess.Popen(on_ray, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while not journal.exists() or journal.read_text().count("\n") < 2:
        assert running.poll() is None
        time.sleep(0.01)
    running.kill()
    running.wait()
    known = journal.read_text()
    subprocess.run([*on_ray, "--resume"], cwd=tmp_path, check=True, capture_output=True)
    assert known.count("\n") >= 2
    plan, listed = plan_run(
        "pointnav", "navigator", split="val", scenes=["apartment_v1"], episodes=6, settings=Settings()
    )
    alone = run(plan, listed, tmp_path / "local.jsonl", workers=0)
    assert load_results(tmp_path / "r.json") == json.loads(text_of(results_of(plan, listed, alone)))
