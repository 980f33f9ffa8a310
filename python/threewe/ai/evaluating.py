"""Evaluation of learned policies: how often they get to things that are in sight, on one backend and on others."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from threewe._core import Pose2D
from threewe.ai.agent import PolicyAgent
from threewe.ai.folder import find_policy, read_policy
from threewe.benchmark.attempt import Settings, attempt_with, lost
from threewe.benchmark.episodes import Episode, load_episodes
from threewe.benchmark.runner import Finished, Job, run_jobs
from threewe.benchmark.sampling import SIGHTS, generated_in_sight
from threewe.benchmark.statistics import bootstrap, mean, wilson
from threewe.benchmark.tasks import place_of
from threewe.benchmark.transfer import ratio_interval, with_noise
from threewe.errors import ConfigError

GENERATED = "generated"
WALL_LIMIT = 300.0  # [s] for an episode


@dataclass(frozen=True)
class Evaluation:
    """What a policy is asked to do."""

    episodes: str = "in_sight_v1"
    """a set of ObjectNav by name or file; or `generated`: in buildings that follow from the seed, one each"""
    backends: tuple[str, ...] = ("mock",)
    count: int = 100
    """in each scene, or of generated buildings"""
    seeds: tuple[int, ...] = (0,)
    """of noise, and of generated buildings"""
    randomization: str = "none"
    latency: float | None = None
    """[s] in place of the policy's own"""
    other: bool = False
    """another kind is named that is in sight too; what counts is still whether it gets to the episode's own"""


@dataclass(frozen=True)
class Drive:
    """What an episode came to."""

    backend: str
    seed: int
    episode: Episode
    success: bool
    spl: float
    end: str
    """`stop`, `time`, or what the policy failed of"""
    commands: str
    """SHA-256 of the velocities"""


def evaluate(
    policy: str | Path, what: Evaluation, workers: int = 0, on_done: Callable[[int, int], object] = lambda *_: None
) -> list[Drive]:
    """Drives a policy through episodes, on each backend the same. Raises ConfigError."""
    folder = find_policy(policy)
    read_policy(folder)
    listed = [(seed, episode) for seed in what.seeds for episode in episodes_of(what, seed)]
    if not listed:
        raise ConfigError(f"episodes: none of {what.episodes} has another kind in sight")
    jobs = []
    for backend in what.backends:
        settings = Settings(backend=backend, randomization=what.randomization)
        for seed, episode in listed:
            given = {"folder": str(folder), "episode": episode, "settings": settings, "latency": what.latency}
            key = f"{backend}/{seed}/{episode.scene}/{episode.index}"
            instruction = instruction_to_another(episode) if what.other else ""
            if instruction is None:
                raise ConfigError(f"episodes: in {episode.scene}/{episode.index} no other kind is in sight")
            jobs.append(Job(key, _drive, {**given, "instruction": instruction}, WALL_LIMIT))
    done = 0

    def count(_: Job, __: Finished) -> None:
        nonlocal done
        done += 1
        on_done(done, len(jobs))

    found = run_jobs(jobs, workers, on_done=count)
    drives = []
    for i, (job, one) in enumerate(zip(jobs, found, strict=True)):
        if one.failure and not one.own:
            raise ConfigError(f"episode {job.key} could not be run: {one.failure.splitlines()[-1]}")
        settings = job.arguments["settings"]
        seed, episode = listed[i % len(listed)]
        result = one.result or lost("objectnav", episode, settings, one.failure)
        metrics = result["metrics"]
        commands = hashlib.sha256(result["replayed"]["commands"].encode()).hexdigest()
        end = result["failure"] or result["end"]
        drives.append(Drive(settings.backend, seed, episode, metrics["success"] > 0.5, metrics["spl"], end, commands))
    return drives


def episodes_of(what: Evaluation, seed: int) -> list[Episode]:
    """What is driven with a seed, in its order. Raises ConfigError."""
    if what.episodes == GENERATED:
        drawn = generated_in_sight(seed)
        return list(islice(filter(_among_others, drawn) if what.other else drawn, what.count))
    frozen = load_episodes(what.episodes)
    if frozen["task"] != "objectnav":
        raise ConfigError(f"episodes: {what.episodes} is of {frozen['task']}, not of objectnav")
    chosen = []
    for scene in dict.fromkeys(episode.scene for episode in frozen["episodes"]):
        own = [episode for episode in frozen["episodes"] if episode.scene == scene]
        chosen += [episode for episode in own if not what.other or _among_others(episode)][: what.count]
    return [with_noise(episode, seed) for episode in chosen]


def _among_others(episode: Episode) -> bool:
    return episode.stratum == SIGHTS[1]


def instruction_to_another(episode: Episode) -> str | None:
    """Names another kind than the episode's that is in sight from its start, but no door; it follows from the seed."""
    seen = place_of(episode.scene, Settings.hardware).object_nav.in_sight(Pose2D(*episode.start))
    others = [kind for kind in seen if kind not in (episode.category, "door")]
    return f"go to the {others[episode.seed % len(others)]}" if others else None


def _drive(
    folder: str, episode: Episode, settings: Settings, latency: float | None, instruction: str
) -> dict[str, Any]:
    return attempt_with("objectnav", episode, PolicyAgent(folder, instruction, latency), settings)


def summarize(drives: Sequence[Drive]) -> dict[str, Any]:
    """Success and SPL by backend, scene and stratum, and each backend's success over that of the first."""
    backends = list(dict.fromkeys(drive.backend for drive in drives))
    summary: dict[str, Any] = {backend: _figures([d for d in drives if d.backend == backend]) for backend in backends}
    first = [drive.success for drive in drives if drive.backend == backends[0]]
    for backend in backends[1:]:
        other = [drive.success for drive in drives if drive.backend == backend]
        if any(first):
            low, high = ratio_interval((sum(other), len(other)), (sum(first), len(first)))
            summary[backend]["transfer"] = {"value": sum(other) / sum(first), "low": low, "high": high}
    return summary


def _figures(drives: Sequence[Drive]) -> dict[str, Any]:
    groups: dict[str, list[Drive]] = {"all": list(drives)}
    for drive in drives:
        scene = drive.episode.scene
        place = GENERATED if scene.startswith("building-") else scene
        for group in (place, drive.episode.stratum or "", str(drive.episode.category)):
            groups.setdefault(group, []).append(drive)
    figures: dict[str, Any] = {"ends": dict(Counter(drive.end.split(":")[0] for drive in drives))}
    for name, some in groups.items():
        low, high = wilson(sum(drive.success for drive in some), len(some))
        spls = [drive.spl for drive in some]
        spl_low, spl_high = bootstrap(spls)
        rate = sum(drive.success for drive in some) / len(some)
        figures[name] = {
            "count": len(some),
            "success": {"value": rate, "low": low, "high": high},
            "spl": {"value": mean(spls), "low": spl_low, "high": spl_high},
        }
    return figures
