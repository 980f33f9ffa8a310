"""Runs what depends on the interpreter, the pump and the concurrency tests, on each other Python from 3.11 to 3.13.

    .venv/bin/python tests/other_pythons.py [pytest arguments]

The package is installed there from a wheel, as a user would get it. A Python that is not installed is named as
not shown.
"""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VERSIONS = ["3.11", "3.12", "3.13"]
TESTS = ["test_pump*.py", "test_concurrency*.py"]


def main(arguments: list[str]) -> int:
    """Runs the tests on every other Python there is; 1 if any of them failed."""
    tests = [str(path) for pattern in TESTS for path in sorted((ROOT / "tests/python").glob(pattern))]
    if not tests:
        print("other Pythons: there are no tests for them")
        return 0
    failed = 0
    for version, python in interpreters().items():
        if python is None:
            print(f"Python {version}: not shown, it is not installed")
            continue
        print(f"Python {version}", flush=True)
        failed |= subprocess.run([environment(version, python), "-m", "pytest", "-q", *(arguments or tests)]).returncode
    return int(bool(failed))


def interpreters() -> dict[str, Path | None]:
    """Each supported version but our own, and where it is: on the PATH or under pyenv."""
    current = f"{sys.version_info.major}.{sys.version_info.minor}"
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    found: dict[str, Path | None] = {}
    for version in VERSIONS:
        if version != current:
            candidates = [Path(f"python{version}"), *sorted(pyenv.glob(f"{version}.*/bin/python3"), reverse=True)]
            found[version] = next((python for python in candidates if runs(python, version)), None)
    return found


def runs(python: Path, version: str) -> bool:
    """Whether this is an interpreter of that version (a pyenv shim may exist for one that is switched off)."""
    code = f"import ensurepip, sys; sys.exit(not sys.version.startswith('{version}.'))"
    try:
        return subprocess.run([python, "-c", code], capture_output=True).returncode == 0
    except OSError:
        return False


def environment(version: str, python: Path) -> Path:
    """The interpreter of a virtual environment that has the package of now installed."""
    tree = ROOT / "build" / f"py{version.replace('.', '')}"
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    requirements = [
        *project["build-system"]["requires"],
        *project["project"]["dependencies"],
        *project["dependency-groups"]["test"],
    ]
    venv_python = tree / "venv/bin/python"
    pip = [venv_python, "-m", "pip", "-q", "--disable-pip-version-check"]
    stamp = tree / "requirements"
    if not stamp.exists() or stamp.read_text() != "\n".join(requirements):
        subprocess.run([python, "-m", "venv", "--clear", tree / "venv"], check=True)
        subprocess.run([*pip, "install", *requirements], check=True)
        stamp.write_text("\n".join(requirements))

    # the libraries come from the compiler cache; from 3.12 on one module serves all versions
    build_tree = ROOT / "build" / ("py311" if version == "3.11" else "abi3")
    options = [f"build-dir={build_tree}/cmake", "cmake.define.THREEWE_DEVELOPER=ON"]
    for product in ["TESTS", "EXAMPLES", "BENCHMARKS"]:
        options.append(f"cmake.define.THREEWE_BUILD_{product}=OFF")
    wheel = next(build_tree.glob("*.whl"), None)
    if wheel is None or build_tree not in BUILT:
        for old in build_tree.glob("*.whl"):
            old.unlink()
        settings = [f"--config-settings={option}" for option in options]
        command = [*pip, "wheel", "--no-build-isolation", "--no-deps", "-w", build_tree, *settings, ROOT]
        subprocess.run(command, check=True, env={**os.environ, "CXX": "c++"})  # named as in build/dev, for the cache
        BUILT.add(build_tree)
        wheel = next(build_tree.glob("*.whl"))
    subprocess.run([*pip, "install", "--no-deps", "--force-reinstall", wheel], check=True)
    return venv_python


BUILT: set[Path] = set()

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
