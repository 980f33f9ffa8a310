"""Regression by pairs: fixed drives are the ones on file, a change of one parameter or sign is caught and named."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import threewe
from threewe.benchmark.runner import Job, run_jobs

from verify.pairs import __main__ as pairs
from verify.pairs import baseline
from verify.pairs.comparison import differences, summary
from verify.pairs.drives import SETS
from verify.pairs.outcomes import Outcome, perform
from verify.pairs.planted import PLANTED, Change, planted

KNOWN = {drive.name: (name, drive) for name, drives in SETS.items() for drive in drives()}


def driven(name: str) -> Outcome:
    """Drives one of the fixed episodes in a process of its own."""
    drive = KNOWN[name][1]
    arguments = {"function": drive.function, "arguments": drive.arguments, "target": ""}
    [finished] = run_jobs([Job(name, perform, arguments, 300.0)], 1)
    assert not finished.failure
    return finished.result


def on_file(name: str) -> Outcome:
    kind = KNOWN[name][0]
    return baseline.read(kind, [drive.name for drive in SETS[kind]()])[name]


@pytest.mark.parametrize("change", PLANTED, ids=str)
def test_a_planted_change_is_named_by_the_drive_that_it_changes(change: Change) -> None:
    with planted(change):
        now = driven(change.drive)
    [found] = differences({change.drive: on_file(change.drive)}, {change.drive: now})
    assert str(found).startswith(change.drive)
    assert found.changes()


def test_twenty_changes_are_planted() -> None:
    assert len(set(map(str, PLANTED))) == 20


@pytest.mark.parametrize("name", sorted({change.drive for change in PLANTED}))
def test_without_a_change_the_drive_is_the_one_on_file(name: str) -> None:
    assert driven(name) == on_file(name)


def test_unchanged_drives_are_proved_so(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", ["pairs", "driving", "--only", "wall/3we_standard_v2"])
    assert pairs.main() == 0
    printed = capsys.readouterr().out
    assert "proved unchanged: each drive is the one on file to the bit" in printed
    assert printed.splitlines()[-1] == "pairs: 2 passed, 0 failed"


def one(**changes: Any) -> Outcome:
    return {"reason": "reached", "success": True, "seconds": 10.0, "metres": 4.0, "hash": "0"} | changes


def test_a_difference_says_what_changed_and_who_got_worse() -> None:
    before = {"a": one(), "b": one(), "c": one(), "d": one()}
    now = {
        "a": one(),
        "b": one(hash="1"),
        "c": one(seconds=12.5, hash="1"),
        "d": one(reason="lost", success=False, seconds=9.0, metres=4.5, hash="1"),
    }
    lines = [" ".join(str(found).split()) for found in differences(before, now)]
    assert lines == [
        "b other the same figures on another trajectory",
        "c other +2.50 s",
        "d WORSE reached -> lost, -1.00 s, +0.500 m",
    ]
    assert summary(before, now)[0] == "success: 0 better, 1 worse; -25.000 % [-104.561, +54.561] a drive"


def test_a_drive_that_breaks_is_a_difference() -> None:
    [finished] = run_jobs([Job("x", perform, {"function": one, "arguments": {"this": 1}, "target": "AVX9"}, 60.0)], 1)
    assert "AVX9" in pairs.broken(finished)["reason"]
    assert differences({"x": one()}, {"x": pairs.broken(finished)})


HEAD = {"format": baseline.FORMAT, "release": threewe.__version__}
DRIVE = {"drive": "a", **one()}


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "expected an object of JSON, got ''"),
        ([{**HEAD, "format": "threewe-pairs/0"}], "the format is 'threewe-pairs/0', not 'threewe-pairs/1'"),
        ([{**HEAD, "release": "0.0.1"}], f"of release 0.0.1, and this is {threewe.__version__}"),
        ([HEAD], "a is missing"),
        ([HEAD, DRIVE, {**DRIVE, "drive": "b"}], "b is unknown to verify/pairs/drives.py"),
        ([HEAD, {"drive": "a", "hash": 3}], "2: expected drive, reason, success, seconds, metres, hash"),
        ([HEAD, [1, 2]], "2: expected an object of JSON"),
    ],
)
def test_a_baseline_that_cannot_be_compared_with_is_one_clear_line(
    tmp_path: Path, lines: list[Any], message: str
) -> None:
    (tmp_path / "toy.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    with pytest.raises(baseline.BaselineError) as error:
        baseline.read("toy", ["a"], tmp_path)
    assert message in str(error.value)
    assert str(tmp_path / "toy.jsonl") in str(error.value)
    assert "./dev pairs --renew" in str(error.value)
    assert len(str(error.value).splitlines()) == 1


def test_what_is_written_is_read(tmp_path: Path) -> None:
    baseline.write("toy", {"a": one(), "b": one(seconds=1.0)}, tmp_path)
    assert baseline.read("toy", ["b", "a"], tmp_path) == {"a": one(), "b": one(seconds=1.0)}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["walking"], "no set walking; there are pointnav, driving"),
        (["--target", "AVX9"], "no target AVX9 on this machine; there are"),
        (["--renew", "--only", "wall"], "--renew puts whole sets on file"),
    ],
)
def test_wrong_arguments(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    monkeypatch.setattr("sys.argv", ["pairs", *arguments])
    with pytest.raises(SystemExit):
        pairs.main()
    assert message in capsys.readouterr().err
