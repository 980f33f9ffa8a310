"""Our mapper on logs like those of old robots, against the truth about them."""

import tempfile
from pathlib import Path

import numpy as np
from threewe.slam import accuracy, relation_errors, replay
from threewe.slam.synth import record, true_relations

from verify.harness import Case

SURVEYS = {"laboratory": 0.04, "office_loop": 0.04, "long_corridor": 0.06, "campus_loop": 0.04}
"""[m] that the relations of each may be off."""

TOURS = {
    "corridor_v1": "room_103, archive, workshop, laboratory, waiting_area, room_106, tea_kitchen, room_101",
    "warehouse_v1": "aisles, packing, cold_room, aisles, office, receiving",
}
"""Where doors and racks look alike: the rooms of three laps."""
WRONG = 0.3, np.radians(5.0)
"""[m, rad] A closure that is farther off is wrong."""


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


def closed(seed: int, scene: str) -> Case:
    """How far off the closures of one log are."""
    with tempfile.TemporaryDirectory() as folder:
        survey = Path(folder) / f"{scene}_tour.yaml"
        survey.write_text(f"description: Three laps\nscene: {scene}\nlaps: 3\ntour: [{TOURS[scene]}]\n")
        log, truth = record(str(survey), seed)
    translation, rotation, _ = relation_errors(truth, replay(log).closures)
    wrong = (translation > WRONG[0]) | (rotation > WRONG[1])
    return {
        "right": int((~wrong).sum()),
        "wrong": int(wrong.sum()),
        "translation": float(translation.max(initial=0.0)),
        "rotation": float(np.degrees(rotation.max(initial=0.0))),
    }
