"""What ./dev says where it cannot install what it needs. Programs that it would call are fakes on a PATH of its own."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
AS_ONE_WHO_IS_NOT_ROOT = """
import os, runpy, sys
os.geteuid = lambda: 1000
sys.argv = ["dev", sys.argv[1]]
runpy.run_path("dev", run_name="__main__")
"""
DEBIAN_WITHOUT_PACKAGES = {"dpkg-query": "echo not-installed g++; exit 1"}


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """As much of a clone as ./dev reads before it gives up."""
    for name in ("dev", "pyproject.toml"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    return tmp_path


def dev(clone: Path, command: str, programs: dict[str, str]) -> str:
    """What a ./dev command says that cannot go on, on a machine which has these programs alone."""
    folder = clone / "bin"
    folder.mkdir()
    for name, script in programs.items():
        (folder / name).write_text(f"#!/bin/sh\n{script}\n")
        (folder / name).chmod(0o755)
    done = subprocess.run(
        [sys.executable, "-c", AS_ONE_WHO_IS_NOT_ROOT, command],
        cwd=clone,
        env={"PATH": str(folder)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert not (clone / ".venv").exists()
    return done.stdout + done.stderr


@pytest.mark.parametrize("command", ["build", "demo", "test", "verify", "wheel"])
def test_without_root_and_sudo_it_says_what_to_ask_for_and_how_to_do_without(clone: Path, command: str) -> None:
    said = dev(clone, command, DEBIAN_WITHOUT_PACKAGES)
    assert "neither root nor is there sudo" in said
    (line,) = re.findall(r"^ +apt-get install .*$", said, re.M)
    assert {"g++", "cmake", "ninja-build", "libyaml-cpp-dev", "libhwy-dev", "libeigen3-dev"} <= set(line.split())
    assert "env/bin/pip install 'threewe-<version>.whl[demo]'" in said


def test_a_wheel_that_lies_ready_is_named(clone: Path) -> None:
    tag = "cp311-cp311" if sys.version_info[:2] == (3, 11) else "cp312-abi3"
    (clone / "dist").mkdir()
    for name in (f"threewe-0.1.0-{tag}-manylinux_2_35_x86_64.whl", "threewe-0.1.0-cp310-cp310-linux_x86_64.whl"):
        (clone / "dist" / name).touch()
    said = dev(clone, "build", DEBIAN_WITHOUT_PACKAGES)
    assert f"env/bin/pip install 'dist/threewe-0.1.0-{tag}-manylinux_2_35_x86_64.whl[demo]'" in said


def test_only_what_is_missing_is_asked_for(clone: Path) -> None:
    script = 'shift 3; for package; do [ "$package" = libfmt-dev ] || echo "installed $package"; done'
    said = dev(clone, "build", {"dpkg-query": script})
    assert re.findall(r"^ +apt-get install (.*)$", said, re.M) == ["--no-install-recommends libfmt-dev"]


def test_who_may_not_use_sudo_is_told_the_same(clone: Path) -> None:
    sudo = 'echo "you are not in the sudoers file" >&2; exit 1'
    said = dev(clone, "build", {**DEBIAN_WITHOUT_PACKAGES, "sudo": sudo})
    assert "you are not in the sudoers file" in said
    assert re.search(r"^ +apt-get install .* g\+\+ ", said, re.M)
    assert "pip install 'threewe-<version>.whl[demo]'" in said


def test_on_another_linux_it_names_the_tools_that_it_cannot_do_without(clone: Path) -> None:
    said = dev(clone, "build", {"cmake": "exit 0"})
    assert "neither Debian nor Ubuntu" in said
    assert "libyaml-cpp-dev" in said
    assert "c++, ninja" in said
    assert "pip install 'threewe-<version>.whl[demo]'" in said


def test_a_night_that_was_killed_goes_on_after_the_steps_that_passed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    steps_of = runpy.run_path(str(ROOT / "dev"))["Steps"]
    done: list[str] = []

    def step(name: str, fails: bool) -> bool:
        done.append(name)
        return fails

    for again in (False, False, True):
        steps = steps_of(tmp_path / "night", again)
        steps.do("first", step, "first", False)
        steps.do("second", step, "second", len(done) < 3)
        status = steps.report()
    assert done == ["first", "second", "second", "first", "second"]
    printed = capsys.readouterr().out
    assert re.search(r"^FAILED +0\.0 min  second$", printed, re.M)
    assert len(re.findall(r"^ok +0\.0 min  in all$", printed, re.M)) == 3
    assert status == 0
