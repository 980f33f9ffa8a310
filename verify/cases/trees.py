"""Build trees beside the one of every day, for programs that are compiled in another way."""

import fcntl
import os
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ROOT / "build/dev/verify"  # of the everyday tree


def build(tree: Path, program: str, make_tree: Callable[[], None]) -> Path:
    """A verify program, built when it is out of date; one process at a time."""
    tree.mkdir(parents=True, exist_ok=True)
    with (tree / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (tree / "build.ninja").exists():
            make_tree()
        subprocess.run(["cmake", "--build", tree, "--target", program], check=True, stdout=subprocess.DEVNULL)
    return tree / "verify" / program


def configure(tree: Path, settings: Mapping[str, str], environment: Mapping[str, str] | None = None) -> None:
    """A build tree with these settings of CMake."""
    ours = {"THREEWE_DEVELOPER": "ON", "THREEWE_BUILD_EXAMPLES": "OFF", "THREEWE_BUILD_BENCHMARKS": "OFF"}
    options = [f"-D{name}={value}" for name, value in {**ours, **settings}.items()]
    command = ["cmake", "-S", ROOT, "-B", tree, "-G", "Ninja", *options]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env={**os.environ, **(environment or {})})
