"""Tests may use what measures; what measures uses neither tests nor one another: no cycle of imports or includes."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
MAY_USE = {"benchmarks": [], "verify": [], "tests": ["benchmarks", "verify"]}
INCLUDED_FROM = {"tests": ["tests/cpp"], "verify": ["verify", "verify/worlds"], "benchmarks": ["benchmarks"]}


@pytest.mark.parametrize("folder", MAY_USE)
def test_folders_use_only_what_they_may(folder: str) -> None:
    wrong = [
        f"{file.relative_to(ROOT)} uses {other}"
        for file in files(folder)
        for other in used(file)
        if other != folder and other not in MAY_USE[folder]
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("folder", MAY_USE)
def test_each_folder_has_its_sentence(folder: str) -> None:
    assert f"- `{folder}`" in (ROOT / "CONTRIBUTING.md").read_text()


def test_the_rule_can_tell(tmp_path: Path) -> None:
    file = tmp_path / "one.py"
    file.write_text("import math\nfrom tests.fuzz import x\nimport verify.harness\n")
    assert list(used(file)) == ["tests", "verify"]
    file = tmp_path / "one.cpp"
    file.write_text('#include "draw.hpp"\n#include "nav/mppi_course.hpp"\n#include "threewe/core/pose.hpp"\n')
    assert list(used(file)) == ["tests", "verify"]


def files(folder: str) -> list[Path]:
    return [path for ending in ("py", "cpp", "hpp") for path in (ROOT / folder).rglob(f"*.{ending}")]


def used(file: Path) -> Iterator[str]:
    """The folders that a file imports or includes from."""
    text = file.read_text()
    if file.suffix == ".py":
        for name in re.findall(r"^\s*(?:from|import) (\w+)", text, re.M):
            if name in MAY_USE:
                yield name
        return
    for name in re.findall(r'^#include "([^"]+)"', text, re.M):
        if not (file.parent / name).exists():
            yield from (one for one, roots in INCLUDED_FROM.items() if any((ROOT / r / name).exists() for r in roots))
