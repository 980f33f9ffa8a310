"""Instructions lead where they should: followed by text and map alone, in the shipped scenes and in generated ones."""

import subprocess
from collections.abc import Callable
from pathlib import Path

from verify.harness import Case, Experiment, Row, Verdict, wilson

PROGRAM = Path(__file__).resolve().parent.parent / "build/dev/verify/verify_instructions"
SCENES = [
    "apartment_v1",
    "cluttered_v1",
    "corridor_v1",
    "dynamic_v1",
    "office_v2",
    "outdoor_v1",
    "warehouse_v1",
    "generated",
    "generated",
    "generated",
]
EACH = 50  # instructions of a case


def follow(seed: int) -> Case:
    """Instructions of one scene, and how many were followed."""
    scene = SCENES[seed % len(SCENES)]
    output = subprocess.run([PROGRAM, str(seed), scene, str(EACH)], capture_output=True, text=True, check=True).stdout
    lines = [line.partition(" ") for line in output.splitlines()]
    counts = {name: int(value) for name, _, value in lines if name != "text"}
    return {"scene": scene, "texts": [text for name, _, text in lines if name == "text"], **counts}


def pooled(name: str, hits: str, of: str, holds: Callable[[float], bool], target: str) -> Row:
    """A share of all cases' instructions."""

    def judge(cases: list[Case], _sample: bool) -> Verdict:
        count, total = (sum(case.get(key, 0) for case in cases) for key in (hits, of))
        complete = total > 0 and all(of in case for case in cases)
        low, high = wilson(count, max(total, 1))
        ok = complete and holds(count / total)
        figure = f"{count}/{total} = {count / max(total, 1):.1%}"
        return Verdict(figure, target, "pass" if ok else "FAIL", f"[{low:.1%}, {high:.1%}]")

    return Row(name, judge)


def distinct(cases: list[Case], _sample: bool) -> Verdict:
    """How many texts there are among all instructions."""
    texts = [text for case in cases for text in case.get("texts", [])]
    share = len(set(texts)) / len(texts) if texts else 0.0
    figure = f"{len(set(texts))} of {len(texts)}"
    return Verdict(figure, ">= 95 %", "pass" if share >= 0.95 else "FAIL")


EXPERIMENTS = [
    Experiment(
        f"{EACH} instructions a case, in shipped and generated scenes",
        follow,
        cases=40,
        sample=3,
        rows=[
            pooled("followed by text and map", "followed", "instructions", lambda s: s >= 0.98, ">= 98 %"),
            pooled("with another's text", "shuffled", "instructions", lambda s: s <= 0.30, "<= 30 %"),
            pooled("with left and right swapped", "swapped", "with_sides", lambda s: s <= 0.30, "<= 30 %"),
            Row("distinct texts", distinct),
        ],
    )
]
