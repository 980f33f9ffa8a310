"""Jobs that raise, hang, die or eat memory cost themselves alone, and interrupted runs go on."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from threewe import ConfigError
from threewe.benchmark.runner import Finished, Job, Journal, run_jobs


def work(how: str, folder: str) -> dict[str, Any]:
    """Does it in that way."""
    if how == "raises":
        raise ValueError("boom")
    if how == "hangs":
        time.sleep(60.0)
    if how == "exits":
        os._exit(3)
    if how == "eats memory":
        return {"size": len(bytearray(8 << 30))}
    if how == "is killed once":
        mark = Path(folder, "killed")
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
    if how == "kills itself":
        os.kill(os.getpid(), signal.SIGKILL)
    return {"how": how}


def jobs(tmp_path: Path, *ways: str) -> list[Job]:
    limits = {"hangs": 0.3}
    return [
        Job(f"{i} {how}", work, {"how": how, "folder": str(tmp_path)}, limits.get(how, 60.0))
        for i, how in enumerate(ways)
    ]


WAYS = ("well", "raises", "hangs", "exits", "eats memory", "is killed once", "kills itself", "well")


def test_bad_jobs_cost_themselves_alone(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "journal.jsonl")
    done = run_jobs(jobs(tmp_path, *WAYS), 2, journal, memory=2 << 30)
    failures = {how: one.failure for how, one in zip(WAYS, done, strict=True)}
    assert "ValueError: boom" in failures["raises"]
    assert failures["hangs"] == "took longer than 0.3 s"
    assert failures["exits"] == "its process died with status 3"
    assert failures["eats memory"] == "used too much memory"
    assert failures["kills itself"] == "its process died by signal 9"
    assert [one.result for one in done if not one.failure] == [
        {"how": how} for how in ("well", "is killed once", "well")
    ]
    assert [one.own for one in done] == [False, False, True, True, True, False, True, False]
    again = Journal(tmp_path / "journal.jsonl")
    assert len(again) == 3
    assert again.find("0 well") == Finished({"how": "well"}, seconds=again.find("0 well").seconds)  # type: ignore[union-attr]


def test_a_run_goes_on_from_its_journal(tmp_path: Path) -> None:
    path = tmp_path / "journal.jsonl"
    run_jobs(jobs(tmp_path, "well"), 1, Journal(path, {"agent": "one"}))
    with path.open("a") as file:
        file.write('{"key": "1 well", "seco')  # cut off
    ran: list[tuple[str, bool]] = []

    def tell(job: Job, finished: Finished) -> None:
        ran.append((job.key, finished.known))

    done = run_jobs(jobs(tmp_path, "well", "well"), 1, Journal(path, {"agent": "one"}), on_done=tell)
    assert [one.result for one in done] == [{"how": "well"}] * 2
    assert ran == [("0 well", True), ("1 well", False)], "the first is from the journal"
    keys = [json.loads(line).get("key") for line in path.read_text().splitlines()]
    assert keys == [None, "0 well", "1 well"], "nothing twice, nothing lost"
    with pytest.raises(ConfigError, match="the journal of another run"):
        Journal(path, {"agent": "two"})


def test_an_interrupted_run_keeps_what_has_finished(tmp_path: Path) -> None:
    path = tmp_path / "journal.jsonl"

    def interrupt(job: Job, _: Finished) -> None:
        if job.key == "0 well":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_jobs(jobs(tmp_path, "well", "well", "well"), 1, Journal(path), on_done=interrupt)
    assert len(Journal(path)) == 1


ORPHAN = """
import sys
from threewe.benchmark.runner import Job, run_jobs
from benchmark.test_runner import note_and_hang
run_jobs([Job("hangs", note_and_hang, {"file": sys.argv[1]}, 100.0)], 1)
"""


def note_and_hang(file: str) -> dict[str, Any]:
    """Writes its process down, and does nothing for long."""
    Path(file).write_text(f"{os.getpid()} \n")
    time.sleep(100.0)
    return {}


def test_a_job_ends_with_a_runner_that_is_killed(tmp_path: Path) -> None:
    file = tmp_path / "process"
    path = os.pathsep.join([str(Path(__file__).parents[1]), str(Path(__file__).parents[3])])
    runner = subprocess.Popen([sys.executable, "-c", ORPHAN, str(file)], env={**os.environ, "PYTHONPATH": path})
    while not file.exists() or not file.read_text().endswith("\n"):
        assert runner.poll() is None
        time.sleep(0.1)
    runner.kill()
    runner.wait()
    job = Path("/proc", file.read_text().strip())
    for _ in range(300):
        if not job.exists():
            return
        time.sleep(0.1)
    pytest.fail("30 s later it goes on")
