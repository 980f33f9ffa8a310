"""Mistakes that strangers make in a backend: mypy shows the line, or else `check_backend` names what is wrong.

Each file of wrong_backends/ is examples/06_toy_backend.py with one fault. It either has `# error: CODE` at the line of
which `mypy --strict` complains, and nowhere else, or its types are right and its docstring lists the checks that fail,
and no others.
"""

from __future__ import annotations

import importlib
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import threewe
from threewe.testing import check_backend

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted((ROOT / "tests/python/wrong_backends").glob("*.py"))
CHECKS = {
    path.stem: match[1] for path in FILES if (match := re.search(r"\nfails: ([\w, \n]+)\n\"\"\"", path.read_text()))
}


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wrong backends, and the honest one under a name that can be imported."""
    folder = tmp_path_factory.mktemp("wrong_backends")
    shutil.copy(ROOT / "examples/06_toy_backend.py", folder / "toy.py")
    for path in FILES:
        shutil.copy(path, folder)
    return folder


def test_types_show_what_they_can_see(folder: Path) -> None:
    pytest.importorskip("mypy", reason="not shown: ./dev test installs mypy")
    expected = {
        (path.stem, number, match[1])
        for path in FILES
        for number, line in enumerate(path.read_text().splitlines(), start=1)
        if (match := re.search(r"# error: (.+)$", line))
    }
    # with the settings of ./dev lint, and so with what mypy remembers of the package
    mypy = [sys.executable, "-m", "mypy", "--strict", folder]
    said = subprocess.run(mypy, cwd=ROOT, capture_output=True, text=True).stdout
    errors = re.findall(r"^.*?(\w+)\.py:(\d+): error: .*\[([\w-]+)\]$", said, re.MULTILINE)
    assert {(name, int(line), code) for name, line, code in errors} == expected, said
    assert sorted([*CHECKS, *(name for name, _, _ in expected)]) == [path.stem for path in FILES]
    assert len(FILES) >= 12


@pytest.mark.parametrize("of_all", [False, pytest.param(True, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("name", CHECKS)
def test_checks_name_what_types_cannot_see(
    name: str, of_all: bool, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every check that it names fails; by night, no other one does."""
    monkeypatch.syspath_prepend(folder)
    threewe.register_backend(name, importlib.import_module(name).Wrong)
    named = re.split(r",\s", CHECKS[name])
    results = check_backend(name, checks=None if of_all else named, show=False)
    assert {result.name for result in results if not result.passed} == set(named)
