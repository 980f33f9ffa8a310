"""ObjectNav and VLN: goals are as pictures show them, instructions can be followed by their text."""

import subprocess

from verify import camera
from verify.cases.trees import PROGRAMS
from verify.harness import Case, Experiment, Row, counted_of, whole_of, worst_of

SCENES = [*camera.SCENES, "generated", "generated", "generated"]
EACH = 50  # episodes of a case


def follow(seed: int) -> Case:
    """Instructions of one scene, and how many were followed."""
    return run("verify_instructions", seed)


def look(seed: int) -> Case:
    """Episodes of ObjectNav in one scene, and what the renderer's pictures show in them."""
    return run("verify_object_nav", seed)


def run(program: str, seed: int) -> Case:
    """What a program counts in one scene, and the texts that it prints: all, and those that the other parser lost."""
    scene = SCENES[seed % len(SCENES)]
    command = [str(PROGRAMS / program), str(seed), scene, str(EACH)]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    lines = [line.partition(" ") for line in output.splitlines()]
    counts = {name: int(value) for name, _, value in lines if name not in ("text", "lost")}
    texts = {kind: [text for name, _, text in lines if name == kind] for kind in ("text", "lost")}
    return {"scene": scene, **texts, **counts}


def share(name: str, hits: str, of: str, **target: float) -> Row:
    """A share of the counts of all cases."""
    return counted_of(name, lambda case: case[hits], lambda case: case[of], **target)


def distinct(cases: list[Case]) -> tuple[str, str, bool]:
    """How many texts there are among all instructions."""
    texts = [text for case in cases for text in case["text"]]
    return f"{len(set(texts))} of {len(texts)}", ">= 95 %", len(set(texts)) >= 0.95 * len(texts)


EXPERIMENTS = [
    Experiment(
        "VLN, instructions in shipped and generated scenes",
        follow,
        cases=40,
        rows=[
            share("followed by text and map", "followed", "instructions", at_least=0.98),
            share("by a parser that shares no code", "by_independent_parser", "instructions", at_least=0.95),
            share("with another's text", "shuffled", "instructions", at_most=0.30),
            share("with left and right swapped", "swapped", "with_sides", at_most=0.30),
            whole_of("distinct texts", distinct),
        ],
    ),
    Experiment(
        "ObjectNav, episodes in shipped and generated scenes",
        look,
        cases=20,
        rows=[
            worst_of("goal in view at the start", lambda case: case["seen_at_start"], at_most=0.0),
            share("STOP can be right where the path ends", "right_at_end", "episodes", at_least=0.99),
            counted_of(
                "silhouettes unlike a picture of the thing alone",
                lambda case: case["silhouettes_off"],
                lambda case: case["silhouettes"],
                form="{:.2%}",
                at_most=0.001,
            ),
        ],
    ),
]
