"""Reads ten million hostile inputs of each format: no crash, no hang over 5 s, no more memory than stated."""

import re
import subprocess
import sys

from verify.cases.trees import ROOT
from verify.harness import Case, Experiment, all_of

CASES = 100
INPUTS = 100_000  # of a case: coverage found by one is where the next begins
FUZZERS = ROOT / "tests/fuzz"
NATIVE = {path.name.removesuffix("_fuzzer.cpp") for path in FUZZERS.glob("*_fuzzer.cpp")}
FORMATS = sorted(NATIVE | {path.name for path in (FUZZERS / "corpus").iterdir()})


def read_inputs(seed: int, name: str, inputs: int) -> Case:
    """One stretch of fuzzing."""
    if name in NATIVE and not (ROOT / "build/fuzz/tests/fuzz" / f"{name}_fuzzer").exists():
        return {"not_shown": "the fuzzers are not built: `./dev fuzz` builds them"}
    command = [sys.executable, "-m", "tests.fuzz", name, "--runs", str(inputs), "--seed", str(seed % 2**31)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return {"ok": done.returncode == 0 and inputs_of(done.stdout) >= inputs, "said": done.stdout + done.stderr}


def inputs_of(printed: str) -> int:
    """How many were read, by the line of a format; libFuzzer counts its seeds too."""
    counted = re.search(r" (\d+) inputs ", printed)
    return int(counted[1]) if counted else 0


EXPERIMENTS = [
    Experiment(
        f"{name} inputs",
        read_inputs,
        {"name": name, "inputs": INPUTS},
        cases=CASES,
        rows=[all_of(f"stretches of {INPUTS} without a failure", lambda case: case["ok"])],
        limit=36_000.0,
        by_night=False,
    )
    for name in FORMATS
]
