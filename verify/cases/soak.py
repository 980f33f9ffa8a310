"""Runs verify_soak, if wanted compiled with assertions: ours, and the standard library's on indices and optionals."""

import functools
import subprocess
from pathlib import Path
from typing import Any

from verify.cases.trees import PROGRAMS, ROOT, build, configure

TREE = ROOT / "build" / "checked"


@functools.cache
def checked_program() -> Path:
    """The one with assertions, built when it is out of date."""
    flags = {"CMAKE_BUILD_TYPE": "None", "CMAKE_CXX_FLAGS": "-O2 -D_GLIBCXX_ASSERTIONS"}
    return build(TREE, "verify_soak", lambda: configure(TREE, flags))


def soak(seed: int, gate: str, assertions: bool) -> dict[str, Any]:
    """A million random steps in a random scene; a failed assertion ends the program."""
    program = checked_program() if assertions else PROGRAMS / "verify_soak"
    done = subprocess.run([program, str(seed), gate], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"verify_soak {seed} {gate} ended with {done.returncode}: {done.stderr}")
    return {name: int(value) for name, value in (word.split("=") for word in done.stdout.split())}
