"""Commands in English: drawn plans come back from their sentences, handwritten ones are read as they were meant."""

import subprocess

from verify.cases.finding import SCENES, find
from verify.cases.handwritten_commands import PARTS, read_handwritten
from verify.cases.trees import PROGRAMS
from verify.harness import Case, Experiment, Row, counted_of, known_miss, share_of

EACH = 50  # commands of a case


def read_drawn(seed: int) -> Case:
    """Drawn commands, and how many of them were read as the right plan, or as a wrong one instead of a question."""
    command = [str(PROGRAMS / "verify_commands"), str(seed), str(EACH)]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    counts = {name: int(value) for name, _, value in (line.partition(" ") for line in lines) if name != "lost"}
    return {"commands": EACH, "lost": [line for line in lines if line.startswith("lost ")], **counts}


def share(hits: str, name: str, **target: float) -> Row:
    """A share of the commands of all cases."""
    return counted_of(name, lambda case: case[hits], lambda case: case["commands"], **target)


EXPERIMENTS = [
    Experiment(
        "commands, drawn from the lexicon",
        read_drawn,
        cases=40,
        sample=6,
        rows=[
            share("right", "drawn commands read as the right plan", at_least=0.995),
            share("wrong_plan", "a wrong plan instead of a question", at_most=0.02),
        ],
    ),
    Experiment(
        "commands, written by hand",
        read_handwritten,
        variants=[{"part": part} for part in range(PARTS)],
        cases=PARTS,
        sample=PARTS,
        rows=[
            share("right", "handwritten commands read as the right plan", at_least=0.95),
            share("wrong_plan", "a wrong plan instead of a question", at_most=0.02),
        ],
    ),
    Experiment(
        "find the KIND, in an unknown map",
        find,
        variants=[{"scene": scene} for scene in SCENES],
        cases=100 * len(SCENES),
        sample=3 * len(SCENES),
        rows=[
            share_of("found, by the rule of 3we/ObjectNav-v1", lambda case: case["found"], at_least=0.6),
            known_miss(
                counted_of(
                    "claimed, verified and wrong", lambda case: case["claimed_wrong"], lambda _: 1.0, at_most=0.03
                ),
                0.25,
                "the detector is a first one: desks, tables, shelves and refrigerators are mixed up",
            ),
        ],
    ),
]
