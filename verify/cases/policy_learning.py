"""Demonstrations that are collected, and a policy that learns from them: what arrives, and how long it takes."""

import asyncio
import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from threewe.ai.collecting import Collection, collect_demonstrations
from threewe.ai.evaluating import Evaluation, evaluate
from threewe.ai.training import train_policy
from threewe.data.lerobot import Dataset

from verify.harness import Case

DEMONSTRATIONS = 2000
PASSES = 4
UNSEEN = 10**9  # added to a seed: buildings of no demonstration
HELD_OUT = "held out "


def collect(seed: int, episodes: int) -> Case:
    """Demonstrations in generated buildings: how many arrive, and how fast they are made."""
    with TemporaryDirectory() as folder:
        begun = time.process_time()
        arrived = asyncio.run(
            collect_demonstrations(Path(folder, "demos"), episodes, Collection(seed=seed, randomization="paper"))
        )
        seconds = time.process_time() - begun
        dataset = Dataset.open(Path(folder, "demos"))
        driven = dataset.info.total_frames / dataset.fps
    return {"arrived": arrived, "episodes": episodes, "driven": driven, "seconds": seconds}


def learn(seed: int, demonstrations: int = DEMONSTRATIONS) -> Case:
    """Training from a dataset of 2,000 demonstrations, decoding included: wall time, and the loss of held-out ones."""
    with TemporaryDirectory() as folder:
        demos = _collected(Path(folder, "demos"), demonstrations, Collection(seed=seed))
        begun = time.monotonic()
        lines = _trained(Path(folder, "policy"), [demos], seed)
        minutes = (time.monotonic() - begun) / 60
    losses = [float(line.rpartition(HELD_OUT)[2]) for line in lines if HELD_OUT in line]
    return {"minutes": minutes, "first": losses[0], "last": losses[-1]}


def learn_and_drive(seed: int, demonstrations: int, generated: int, in_each_scene: int) -> Case:
    """A policy that is trained from scratch: how often it arrives in unseen buildings, and in the static scenes.

    Half of the demonstrations are those of the navigator, and in the other half a policy of the first half disturbs.
    """
    with TemporaryDirectory() as name:
        folder, half = Path(name), demonstrations // 2
        undisturbed = _collected(folder / "demos", half, Collection(seed=2 * seed))
        _trained(folder / "first", [undisturbed], seed)
        disturbed = Collection(seed=2 * seed + 1, scene="varied", disturbance=str(folder / "first"))
        _trained(folder / "policy", [undisturbed, _collected(folder / "more", half, disturbed)], seed)
        case: Case = {}
        for episodes, count in (("generated", generated), ("in_sight_v1", in_each_scene)):
            what = Evaluation(episodes, count=count, seeds=(UNSEEN + seed,))
            drives = evaluate(folder / "policy", what)
            case[episodes] = {"won": sum(drive.success for drive in drives), "count": len(drives)}
    return case


def _collected(folder: Path, count: int, how: Collection) -> Path:
    asyncio.run(collect_demonstrations(folder, count, replace(how, randomization="paper")))
    return folder


def _trained(folder: Path, demos: list[Path], seed: int) -> list[str]:
    """What training says; the policy is in the folder."""
    lines: list[str] = []
    train_policy(demos, folder, PASSES, seed, 0, lambda line: lines.append(str(line)), mirror=True)
    return lines
