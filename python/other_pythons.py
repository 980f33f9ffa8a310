"""Runs what depends on the interpreter, the pump and the concurrency tests, on each other Python from 3.11 to 3.13.

    .venv/bin/python -m python.other_pythons [pytest arguments]

The package is installed there from a wheel, as a user would get it, and nothing else but pytest. A Python that is not
installed is named as not shown.
"""

import subprocess
import sys
import tomllib
from pathlib import Path

from python.make_wheel import abi, build, interpreters, repair

ROOT = Path(__file__).resolve().parent.parent
TESTS = ["test_pump*.py", "test_concurrency*.py"]


def main(arguments: list[str]) -> int:
    """Runs the tests on every other Python there is; 1 if any of them failed."""
    tests = [str(path) for pattern in TESTS for path in sorted((ROOT / "tests/python").glob(pattern))]
    failed = 0
    for version, python in interpreters().items():
        if python is None:
            print(f"Python {version}: not shown, it is not installed")
            continue
        print(f"Python {version}", flush=True)
        failed |= subprocess.run([environment(version, python), "-m", "pytest", "-q", *(arguments or tests)]).returncode
    return int(bool(failed))


def environment(version: str, python: Path) -> Path:
    """The interpreter of a virtual environment that has the package of now installed."""
    tree = ROOT / "build" / f"py{version.replace('.', '')}"
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    (pytest,) = (each for each in project["dependency-groups"]["test"] if each.startswith("pytest=="))
    requirements = [*project["project"]["dependencies"], pytest]
    venv_python = tree / "venv/bin/python"
    pip = [venv_python, "-m", "pip", "-q", "--disable-pip-version-check"]
    stamp = tree / "requirements"
    if not stamp.exists() or stamp.read_text() != "\n".join(requirements):
        subprocess.run([python, "-m", "venv", "--clear", tree / "venv"], check=True)
        subprocess.run([*pip, "install", *requirements], check=True)
        stamp.write_text("\n".join(requirements))
    if abi(version) not in WHEELS:
        WHEELS[abi(version)] = repair(build(version, python))
    subprocess.run([*pip, "install", "--no-deps", "--force-reinstall", WHEELS[abi(version)]], check=True)
    return venv_python


WHEELS: dict[str, Path] = {}  # made by this process


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
