"""ObjectNav and VLN: goals are as pictures show them, instructions can be followed by their text."""

import subprocess
from collections.abc import Callable

from verify import camera
from verify.cases.trees import PROGRAMS
from verify.harness import Case, Experiment, Row, Verdict, wilson

SCENES = [*camera.SCENES, "generated", "generated", "generated"]
EACH = 50  # episodes of a case


def follow(seed: int) -> Case:
    """Instructions of one scene, and how many were followed."""
    return run("verify_instructions", seed)


def look(seed: int) -> Case:
    """Episodes of ObjectNav in one scene, and what the renderer's pictures show in them."""
    return run("verify_object_nav", seed)


def run(program: str, seed: int) -> Case:
    """What a program counts in one scene, and the texts that it prints: all, and those that lost the stranger."""
    scene = SCENES[seed % len(SCENES)]
    command = [str(PROGRAMS / program), str(seed), scene, str(EACH)]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    lines = [line.partition(" ") for line in output.splitlines()]
    counts = {name: int(value) for name, _, value in lines if name not in ("text", "lost")}
    texts = {kind: [text for name, _, text in lines if name == kind] for kind in ("text", "lost")}
    return {"scene": scene, **texts, **counts}


def pooled(name: str, hits: str, of: str, holds: Callable[[float], bool], target: str) -> Row:
    """A share of the counts of all cases."""

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
    texts = [text for case in cases for text in case.get("text", [])]
    share = len(set(texts)) / len(texts) if texts else 0.0
    return Verdict(f"{len(set(texts))} of {len(texts)}", ">= 95 %", "pass" if share >= 0.95 else "FAIL")


EXPERIMENTS = [
    Experiment(
        "VLN, instructions in shipped and generated scenes",
        follow,
        cases=40,
        sample=3,
        rows=[
            pooled("followed by text and map", "followed", "instructions", lambda s: s >= 0.98, ">= 98 %"),
            pooled("by a stranger who shares no code", "by_stranger", "instructions", lambda s: s >= 0.95, ">= 95 %"),
            pooled("with another's text", "shuffled", "instructions", lambda s: s <= 0.30, "<= 30 %"),
            pooled("with left and right swapped", "swapped", "with_sides", lambda s: s <= 0.30, "<= 30 %"),
            Row("distinct texts", distinct),
        ],
    ),
    Experiment(
        "ObjectNav, episodes in shipped and generated scenes",
        look,
        cases=20,
        sample=3,
        rows=[
            pooled("goal in view at the start", "seen_at_start", "episodes", lambda s: s == 0.0, "none"),
            pooled("STOP can be right where the path ends", "right_at_end", "episodes", lambda s: s >= 0.99, ">= 99 %"),
            pooled(
                "silhouettes unlike a picture of the thing alone",
                "silhouettes_off",
                "silhouettes",
                lambda s: s <= 0.001,
                "<= 0.1 %",
            ),
        ],
    ),
]
