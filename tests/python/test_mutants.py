"""Faults that ./dev mutants plants: one line, one token, and nothing is left of it afterwards."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tests.mutants.faults import Fault, changes, draw

ROOT = Path(__file__).resolve().parents[2]


def test_each_change_is_one_token() -> None:
    assert list(changes("  return a < b && c;  // a < b")) == [
        "  return a <= b && c;  // a < b",
        "  return a < b || c;  // a < b",
    ]
    assert list(changes("  x = 0.5 * y - z;")) == ["  x = 0.5 * y + z;", "  x = 0.5 / y - z;", "  x = 1.0 * y - z;"]
    assert list(changes('  fail("a < b");')) == []


@pytest.mark.parametrize("module", ["core", "nav", "sim", "backend/simulated"])
def test_drawn_faults_are_planted_and_removed_without_a_trace(tmp_path: Path, module: str) -> None:
    fault = draw(ROOT, module, random.Random(7))
    assert fault == draw(ROOT, module, random.Random(7))
    path = tmp_path / fault.file
    path.parent.mkdir(parents=True)
    text = (ROOT / fault.file).read_text()
    path.write_text(text)
    fault.plant(tmp_path)
    changed = [old for old, new in zip(text.splitlines(), path.read_text().splitlines(), strict=True) if old != new]
    assert changed == [fault.before]
    fault.remove(tmp_path)
    assert path.read_text() == text


def test_a_fault_says_where_it_is() -> None:
    assert str(Fault("src/a.cpp", 3, "  a < b;", "  a <= b;")) == "src/a.cpp:3: a < b;  ->  a <= b;"
