"""Files that begin with #! can be started as they are after `git clone`."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def test_programs_are_executable() -> None:
    listing = subprocess.run(["git", "ls-files", "-s"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    modes = {line.split("\t")[1]: line.split()[0] for line in listing.splitlines()}
    programs = {name for name in modes if (ROOT / name).is_file() and (ROOT / name).read_bytes()[:2] == b"#!"}
    assert {"dev", ".ci/run"} <= programs
    assert {name for name in programs if modes[name] != "100755"} == set()
