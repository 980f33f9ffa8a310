"""Installs the peers that come from PyPI into build/peers, an environment of their own: 2 GB on disk.

.venv/bin/python benchmarks/peers/install.py
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
PLACE = HERE.parents[1] / "build" / "peers"
PYTHON = PLACE / "bin" / "python"
PUFFERLIB = "pufferlib==3.0.0"


def main() -> int:
    """Wheels alone, but for PufferLib's Target, which is one file of C; 1 if that fails."""
    subprocess.run([sys.executable, "-m", "venv", PLACE], check=True)
    pip = [PYTHON, "-m", "pip", "-q", "--disable-pip-version-check"]
    subprocess.run([*pip, "install", "--prefer-binary", "-r", HERE / "requirements.txt"], check=True)
    with tempfile.TemporaryDirectory() as folder:
        # its setup fetches libraries for drawing, fails where that is not possible, and leaves what pip has unpacked
        unpack = [*pip, "download", "--no-clean", "--no-deps", "--no-build-isolation", "--no-binary", ":all:"]
        environment = {**os.environ, "TMPDIR": folder, "NO_OCEAN": "1", "NO_TRAIN": "1"}
        subprocess.run([*unpack, PUFFERLIB], cwd=folder, env=environment, capture_output=True)
        sources = next(Path(folder).glob("pip-*/pufferlib_*/pufferlib"), None)
        if sources is None:
            print(f"pip did not unpack {PUFFERLIB}")
            return 1
        build_target(sources)
    print(f"installed into {PLACE}; ./dev bench peers will find them")
    return 0


def build_target(sources: Path) -> None:
    """Compiles its simplest environment, with the options of its setup, against a stand-in for the renderer."""
    asked = "import numpy, sysconfig as s; print(s.get_path('purelib'), numpy.get_include(), s.get_path('include'))"
    words = subprocess.run([PYTHON, "-c", asked], capture_output=True, text=True, check=True).stdout.split()
    packages, *includes = words
    there = Path(packages) / "pufferlib"
    shutil.copytree(sources, there, dirs_exist_ok=True, ignore=shutil.ignore_patterns("resources"))
    target = there / "ocean" / "target"
    module = target / f"binding{sysconfig.get_config_var('EXT_SUFFIX')}"
    options = ["-O2", "-fwrapv", "-shared", "-fPIC", "-DNPY_NO_DEPRECATED_API=NPY_1_7_API_VERSION"]
    folders = [f"-I{folder}" for folder in (HERE / "no_renderer", *includes)]
    subprocess.run(["cc", *options, *folders, target / "binding.c", "-o", module], check=True)


if __name__ == "__main__":
    sys.exit(main())
