"""The fuzzer of formats that are read in Python finds what readers do wrong; ours do nothing wrong."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
import threewe

from tests.fuzz import python_fuzzer


@pytest.mark.parametrize("name", python_fuzzer.FORMATS)
def test_readers_survive(name: str) -> None:
    if name == "rosbag":
        pytest.importorskip("rosbags", reason="not shown: needs rosbags")
    assert python_fuzzer.fuzz(name, 150, 300.0) == (150, "")


def lets_through(path: Path) -> None:
    if b"nan" in path.read_bytes():
        raise KeyError


def dies(path: Path) -> None:
    if b"nan" in path.read_bytes():
        os._exit(3)


def hangs(path: Path) -> None:
    if b"nan" in path.read_bytes():
        time.sleep(60.0)


def computes(path: Path) -> None:
    while b"nan" in path.read_bytes():
        pass


def says_not_where(path: Path) -> None:
    if b"nan" in path.read_bytes():
        raise threewe.ConfigError("something is wrong")


@pytest.mark.parametrize(
    ("reader", "failure"),
    [
        (lets_through, "status 1"),
        (dies, "status 3"),
        (hangs, "hangs for more than 10 s"),
        (computes, "computes for more than 1 s"),
        (says_not_where, "status 1"),
    ],
)
def test_readers_that_do_are_found(
    reader: object, failure: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(python_fuzzer.FORMATS, "relations", (".relations", reader))  # type: ignore[arg-type]
    monkeypatch.setattr(python_fuzzer, "TIME_LIMIT", 1.0)
    if reader is hangs:
        monkeypatch.setattr(python_fuzzer, "WALL_LIMIT", 10.0)
    count, told = python_fuzzer.fuzz("relations", 2000, 300.0)
    assert count < 2000
    assert failure in told
    assert b"nan" in next((tmp_path / "build/fuzz/artifacts").iterdir()).read_bytes()
