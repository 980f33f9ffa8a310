"""Reads ten million hostile inputs of each format: no crash, no hang over 5 s, no more memory than stated."""

from tests.fuzz.__main__ import BUILD, FORMATS, NATIVE, fuzz
from verify.harness import Case, Experiment, share_of

CASES = 100
INPUTS = 100_000  # of a case: coverage found by one is where the next begins


def read_inputs(seed: int, name: str, inputs: int) -> Case:
    """One stretch of fuzzing."""
    if name in NATIVE and not (BUILD / "tests/fuzz" / f"{name}_fuzzer").exists():
        return {"not_shown": "the fuzzers are not built: `./dev fuzz` builds them"}
    count, failure = fuzz(name, inputs, 1e9, seed % 2**31)
    return {"inputs": count, "failure": failure}


EXPERIMENTS = [
    Experiment(
        f"{name} inputs",
        read_inputs,
        {"name": name, "inputs": INPUTS},
        cases=CASES,
        sample=0,
        rows=[share_of(f"stretches of {INPUTS} without a failure", lambda case: not case["failure"], at_least=1.0)],
        limit=36_000.0,
    )
    for name in FORMATS
]
