"""Runs verify_people: a robot that drives among people, and how well it sees them."""

import json
import subprocess

from verify.cases.trees import PROGRAMS
from verify.harness import Case, Row, counted_of, mean_of, worst_of


def among_people(seed: int, scene: str, seconds: int) -> Case:
    """What the program counts in a scene."""
    command = [PROGRAMS / "verify_people", scene, str(seed), str(seconds)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    case: Case = json.loads(done.stdout)
    return case


def share(name: str, part: str, whole: str, *, at_most: float) -> Row:
    """One sum over all cases as a share of another."""
    return counted_of(name, lambda case: case[part], lambda case: case[whole], at_most=at_most)


PEOPLE = [
    share("in sight within 5 m, and not tracked", "missed", "seen", at_most=0.10),
    share("tracks without a person within 0.5 m", "ghosts", "tracks", at_most=0.10),
    share("tracks that never were with a person", "false_tracks", "people", at_most=0.15),
    mean_of("position error, RMS [m]", lambda case: case["position"], at_most=0.20),
    mean_of("velocity error, RMS [m/s]", lambda case: case["velocity"], at_most=0.60),
    worst_of("contact by its own motion [m/s]", lambda case: case["contact"], at_most=0.1),
]
