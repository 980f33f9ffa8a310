"""python -m tests.mutants [--count N] [--seed N] [--module NAME]: plants faults, and names what catches each.

The faults are planted in a clone of its own, `build/mutants`, which `./dev build` makes ready. Each is tried on the C++
tests of its module, on all others, on pairs and on the Python tests, until one of them fails. Each finished fault is a
line of JSON; a run that was killed goes on from there.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

from tests.mutants.faults import Fault, draw, lines_of

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 1800.0  # [s] of one command: a fault may make it hang
SURVIVES, BROKEN = "nothing", "the compiler"


def main() -> int:
    """Tries faults; 1 if one of them is caught by nothing."""
    options = parse()
    tree, journal = prepared(options.tree), ROOT / f"build/mutants-{options.seed}.jsonl"
    known = [json.loads(line) for line in journal.read_text().splitlines()] if journal.exists() else []
    modules = [options.module] if options.module else modules_of(tree)
    draws = random.Random(options.seed)
    caught: Counter[str] = Counter()
    number = 0
    while sum(caught.values()) < options.count:
        module = modules[number % len(modules)]
        fault = draw(tree, module, draws)
        if number < len(known):
            by = known[number]["by"]
        else:
            begun = time.monotonic()
            by = tried(tree, module, fault)
            line = {"module": module, "fault": str(fault), "by": by, "seconds": round(time.monotonic() - begun)}
            with journal.open("a") as file:
                file.write(json.dumps(line) + "\n")
        number += 1
        print(f"{by:28} {fault}", flush=True)
        if by != BROKEN:
            caught[by] += 1
    print(*(f"{count:4} caught by {by}" for by, count in caught.most_common()), sep="\n")
    survivors = caught[SURVIVES]
    print(f"mutants: {sum(caught.values()) - survivors} passed, {survivors} failed")
    return int(survivors > 0)


def prepared(tree: Path) -> Path:
    """Makes the clone of this commit, built, and without a fault."""
    if not (tree / "dev").exists():
        subprocess.run(["git", "clone", "-q", ROOT, tree], check=True)
    subprocess.run(["git", "checkout", "-q", "--", "src"], cwd=tree, check=True)
    subprocess.run(["./dev", "build"], cwd=tree, check=True)
    return tree


def modules_of(tree: Path) -> list[str]:
    """The modules of the library in which there can be a fault."""
    names = re.findall(r"^threewe_module\((\S+)", (tree / "CMakeLists.txt").read_text(), re.M)
    return [name for name in names if lines_of(tree, name)]


def tried(tree: Path, module: str, fault: Fault) -> str:
    """What catches a fault, that is taken out again."""
    fault.plant(tree)
    try:
        return catcher(tree, module)
    finally:
        fault.remove(tree)


def catcher(tree: Path, module: str) -> str:
    """The first that fails of what could."""
    python = tree / ".venv/bin/python"
    ctest = ["ctest", "--test-dir", "build/dev", "-j2", "--timeout", "300", "--stop-on-failure"]
    name = module.replace("/", "_")
    if fails(tree, ["cmake", "--build", "build/dev", "--target", "all"]):
        return BROKEN
    if fails(tree, [*ctest, "-R", f"^{name}$"]):
        return f"C++ tests of {module}"
    if fails(tree, [*ctest, "-E", f"^({name}|find_package)$"]):
        return "other C++ tests"
    if fails(tree, [python, "-m", "verify.pairs"]):
        return "pairs"
    if fails(tree, [python, "-m", "pytest", "-x", "-q", "-n2", "--dist=worksteal", "--ignore=tests/python/rules"]):
        return "Python tests"
    return SURVIVES


def fails(tree: Path, command: list[str | Path]) -> bool:
    """Whether a command fails in a tree, or hangs there."""
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    process = subprocess.Popen(list(map(str, command)), cwd=tree, env=environment, start_new_session=True, **quiet)
    try:
        return process.wait(LIMIT) != 0
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        return True


def parse() -> argparse.Namespace:
    """The options."""
    parser = argparse.ArgumentParser(prog="./dev mutants", description="Plants faults, and names what catches each.")
    parser.add_argument("--count", type=int, default=60, help="faults that compile")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--module", default="", help="of this module only")
    parser.add_argument("--tree", type=Path, default=ROOT / "build/mutants", help="the clone that they are planted in")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
