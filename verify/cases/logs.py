"""Our mapper on logs like those of old robots, against the truth about them."""

from threewe.slam import accuracy, replay
from threewe.slam.synth import record, true_relations

from verify.harness import Case

SURVEYS = {"laboratory": 0.04, "office_loop": 0.04, "long_corridor": 0.06, "campus_loop": 0.04}
"""[m] that the relations of each may be off."""


def mapped(seed: int, survey: str) -> Case:
    """The error of Kuemmerle et al. 2009 on one log, and how fast it was mapped."""
    log, truth = record(survey, seed)
    result = replay(log)
    error = accuracy(result.trajectory, true_relations(truth))
    return {
        "relations": error.relations,
        "translation": error.translation[0],
        "rotation": error.rotation[0],
        "speed": log.seconds / result.computing_seconds,
    }
