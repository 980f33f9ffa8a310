"""Our mapper on logs like those of old robots, against the truth about them."""

import dataclasses
import tempfile
from itertools import pairwise
from pathlib import Path

import numpy as np
from threewe import LaserScan, Pose2D
from threewe.slam import Log, accuracy, relation_errors, replay
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
        "events": len(result.events),
    }


SPOILED = {"dropped": 0.1, "lost": 0.3}
"""Shares of scans that are dropped, and of beams that are lost."""
SCALES = (0.8, 1.2)
"""Odometry that is a fifth off."""


def spoiled(seed: int, survey: str) -> Case:
    """The error where scans are dropped, beams lost and odometry is scaled, all at once; beside it that of the log."""
    log, truth = record(survey, seed)
    relations = true_relations(truth)
    random = np.random.default_rng(seed)
    kept = random.random(len(log.scans)) >= SPOILED["dropped"]
    kept[0] = True
    scale = float(random.choice(SCALES))
    result = replay(
        dataclasses.replace(
            log,
            times=[time for time, keep in zip(log.times, kept, strict=True) if keep],
            scans=[with_lost_beams(scan, random) for scan, keep in zip(log.scans, kept, strict=True) if keep],
            odometry=[pose for pose, keep in zip(scaled(log, scale), kept, strict=True) if keep],
        )
    )
    plain, error = (accuracy(trajectory, relations) for trajectory in (replay(log).trajectory, result.trajectory))
    return {
        "scale": scale,
        "plain": plain.translation[0],
        "translation": error.translation[0],
        "rotation": error.rotation[0],
        "events": sorted({event.incident for event in result.events}),
    }


def with_lost_beams(scan: LaserScan, random: np.random.Generator) -> LaserScan:
    ranges = np.array(scan.ranges)
    ranges[random.random(len(ranges)) < SPOILED["lost"]] = 0.0
    return LaserScan(ranges, scan.angle_min, scan.angle_increment, range_min=scan.range_min, range_max=scan.range_max)


def scaled(log: Log, factor: float) -> list[Pose2D]:
    """Its odometry, of which each step and each turn is so much longer."""
    poses = [log.odometry[0]]
    for before, after in pairwise(log.odometry):
        step = before.inverse() * after
        poses.append(poses[-1] * Pose2D(factor * step.x, factor * step.y, factor * step.theta))
    return poses


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
