"""The fuzzer of formats that are read in Python finds what readers do wrong; ours do nothing wrong."""

from __future__ import annotations

import os
import random
import re
import time
from pathlib import Path

import numpy as np
import pytest
import threewe

from tests.fuzz import python_fuzzer
from tests.fuzz.__main__ import CORPUS, FORMATS, NATIVE, ROOT


@pytest.mark.parametrize("name", python_fuzzer.FORMATS)
def test_readers_survive(name: str) -> None:
    if name.startswith("rosbag"):
        pytest.importorskip("rosbags", reason="not shown: needs rosbags")
    runs = 60 if name.startswith("rosbag") else 150  # reading a recording takes 20 ms
    assert python_fuzzer.fuzz(name, runs, 300.0) == (len(list((CORPUS / name).iterdir())) + runs, "")


def test_every_native_fuzzer_is_built_and_has_seeds() -> None:
    cmake = (ROOT / "tests/fuzz/CMakeLists.txt").read_text()
    [built] = re.findall(r"set\(formats ([^)]*)\)", cmake)
    assert sorted(built.split()) == sorted(NATIVE)
    for name in FORMATS:
        assert any((CORPUS / name).iterdir()), name


def test_what_a_run_keeps_is_where_the_next_one_begins(tmp_path: Path) -> None:
    first, _ = python_fuzzer.fuzz("relations", 100, 300.0, seed=1, kept=tmp_path)
    kept = set(tmp_path.iterdir())
    assert kept
    assert python_fuzzer.fuzz("relations", 100, 300.0, seed=2, kept=tmp_path) == (first + len(kept), "")
    assert kept <= set(tmp_path.iterdir())


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


def takes(path: Path) -> None:
    if b"nan" in path.read_bytes():
        _ = b"x" * 500_000_000


def takes_in_cpp(path: Path) -> None:
    if b"nan" in path.read_bytes():
        threewe.OccupancyGrid(np.zeros((20_000, 20_000), np.int8), 0.05)


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
        (takes, "status 1"),
        (takes_in_cpp, "status 1"),
        (says_not_where, "status 1"),
    ],
)
def test_readers_that_do_are_found(
    reader: object, failure: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(python_fuzzer.FORMATS, "relations", python_fuzzer.Format(".relations", reader))  # type: ignore[arg-type]
    if reader is computes:
        monkeypatch.setattr(python_fuzzer, "TIME_LIMIT", 1.0)
    if reader is hangs:
        monkeypatch.setattr(python_fuzzer, "WALL_LIMIT", 10.0)
    count, found = python_fuzzer.fuzz("relations", 2000, 300.0)
    assert count < 2000
    assert failure in found
    assert b"nan" in next((tmp_path / "build/fuzz/artifacts").iterdir()).read_bytes()


def read_changed(name: str, count: int, tmp_path: Path) -> list[str]:
    """What came of changes of the contents of seeds: nothing, or the message."""
    form = python_fuzzer.FORMATS[name]
    pool = [path.read_bytes() for path in sorted((python_fuzzer.CORPUS / name).iterdir())]
    draw, path, said = random.Random(1), tmp_path / f"input{form.suffix}", []
    assert form.change_content
    for _ in range(count):
        path.write_bytes(form.change_content(draw.choice(pool), pool, draw))
        try:
            form.read(path)
            said.append("")
        except threewe.ConfigError as error:
            said.append(str(error))
    return said


def test_changed_bundles_are_read_as_far_as_their_results(tmp_path: Path) -> None:
    said = read_changed("bundle", 200, tmp_path)
    assert sum("results.json: " in text for text in said) > 30
    assert sum("manifest.json" in text for text in said) > 20
    assert said.count("") > 20


@pytest.mark.parametrize("name", ["rosbag", "rosbag_sqlite"])
def test_changed_recordings_are_read_as_far_as_their_messages(name: str, tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="not shown: needs rosbags")
    said = read_changed(name, 60, tmp_path)
    assert said.count("") > 20
    assert sum("message " in text or "scan " in text for text in said) > 15
