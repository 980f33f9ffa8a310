"""A benchmark run: an agent through the episodes of a task, and the results as a file holds them."""

from __future__ import annotations

import hashlib
import logging
import os
import platform
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from multiprocessing import parent_process
from pathlib import Path
from typing import Any

from threewe._core import RobotProfile, unknown_name
from threewe.benchmark.agents import Identity, identify
from threewe.benchmark.attempt import Settings, attempt, lost
from threewe.benchmark.episodes import Episode, EpisodeSet, digest, find_episodes, load_episodes
from threewe.benchmark.results import summarize
from threewe.benchmark.runner import Finished, Job, Journal, Result, run_jobs
from threewe.benchmark.tasks import TASKS
from threewe.errors import ConfigError

FORMAT = "threewe-benchmark/1"
EPISODE_LIMIT = 120.0  # [s] of wall time for an episode
MEMORY = 4 << 30  # [bytes] of an agent's process

OnDone = Callable[[int, int, Episode, Finished], object]
"""Called with how many episodes have finished, how many there are, the one that has just finished, and what it was."""


@dataclass(frozen=True)
class Plan:
    """What is run: an agent, and which episodes of which set."""

    task: str
    agent: Identity
    episode_set: str  # its name
    episode_hash: str  # SHA-256 of its file
    scenes: tuple[str, ...]
    episodes: int  # the first so many of each scene
    settings: Settings
    quick: bool = False  # in the native batch, without a robot's own localizer

    def as_fields(self) -> dict[str, Any]:
        """As JSON holds it."""
        return {**asdict(self), "scenes": list(self.scenes)}


def plan_run(
    task: str, agent: str, *, split: str, scenes: Sequence[str], episodes: int, settings: Settings
) -> tuple[Plan, list[Episode]]:
    """The plan of a run, and its episodes in order. `split` is a split or a set's name or file.

    Raises ConfigError for an unknown task, agent, set or scene, with the nearest right name.
    """
    if task not in TASKS:
        raise ConfigError(unknown_name("task", task, list(TASKS)))
    name = split if split.endswith(".json") or "_" in split else f"{task}_{split}_v1"
    frozen, path = load_episodes(name), find_episodes(name)
    if frozen["task"] != task:
        raise ConfigError(f"{path}: episodes of {frozen['task']}, not of {task}")
    if frozen["hardware"] != settings.hardware and settings.official:
        raise ConfigError(f"{path}: episodes of {frozen['hardware']}, not of {settings.hardware}")
    known = list(dict.fromkeys(episode.scene for episode in frozen["episodes"]))
    wanted = known if list(scenes) in ([], ["all"]) else list(scenes)
    for scene in wanted:
        if scene not in known:
            raise ConfigError(unknown_name(f"scene of {frozen['name']}", scene, known))
    if episodes < 1:
        raise ConfigError(f"episodes: expected 1 or more, got {episodes}")
    plan = Plan(task, identify(task, agent), frozen["name"], digest(path), tuple(wanted), episodes, settings)
    return plan, select(frozen, plan)


def select(frozen: EpisodeSet, plan: Plan) -> list[Episode]:
    """The episodes of a plan: the first so many of each scene."""
    return [
        episode
        for scene in plan.scenes
        for episode in [one for one in frozen["episodes"] if one.scene == scene][: plan.episodes]
    ]


def run(
    plan: Plan,
    episodes: Sequence[Episode],
    journal: Path,
    *,
    workers: int = 1,
    limit: float = EPISODE_LIMIT,
    memory: int = MEMORY,
    engine: str = "local",
    address: str | None = None,
    on_done: OnDone = lambda *_: None,
) -> list[Result]:
    """Drives the episodes and returns what each came to, in order.

    `engine` is `local`, processes of this machine, or `ray`, of a cluster at `address`.

    An agent that raises, hangs, dies or uses too much memory costs its episode. What has finished is in the journal,
    from which the same run goes on.
    """
    jobs = [_job_of(plan, episode, limit) for episode in episodes]
    by_key = {job.key: episode for job, episode in zip(jobs, episodes, strict=True)}
    count = 0

    def done(job: Job, finished: Finished) -> None:
        nonlocal count
        count += 1
        on_done(count, len(jobs), by_key[job.key], finished)

    # what an agent failed of is a result too, and only a worker that was killed runs again
    kept = Journal(journal, plan.as_fields())
    if engine == "ray":
        from threewe.benchmark.ray_engine import run_on_ray

        found = run_on_ray(jobs, workers, kept, address=address, memory=memory, on_done=done)
    else:
        found = run_jobs(jobs, workers, kept, memory=memory, on_done=done)
    results = []
    for episode, one in zip(episodes, found, strict=True):
        if one.failure and not one.own:
            raise ConfigError(f"episode {episode.scene}/{episode.index} could not be run: {_reason(one.failure)}")
        results.append(one.result or lost(plan.task, episode, plan.settings, one.failure))
    return results


def _reason(failure: str) -> str:
    """What a user can mend, without the way that led to it; all of it where that is for a developer."""
    _, mendable, message = failure.rpartition("\nthreewe.errors.ConfigError: ")
    return message.strip() if mendable else failure


def _job_of(plan: Plan, episode: Episode, limit: float) -> Job:
    given = {"task": plan.task, "episode": episode, "agent": plan.agent.name, "settings": plan.settings}
    return Job(f"{episode.scene}/{episode.index}/{episode.seed}", _attempt, given, limit)


def _attempt(task: str, episode: Episode, agent: str, settings: Settings) -> Result:
    if parent_process() is not None:  # sensors that slip and recover are no news of a benchmark
        logging.getLogger("threewe").setLevel(logging.ERROR)
    return attempt(task, episode, agent, settings)


def results_of(plan: Plan, episodes: Sequence[Episode], outcomes: Sequence[Result]) -> dict[str, Any]:
    """Results as a file holds them: the same bytes for the same plan and library."""
    rows = [
        {"episode": _key_of(episode), **{name: value for name, value in outcome.items() if name != "replayed"}}
        for episode, outcome in zip(episodes, outcomes, strict=True)
    ]
    return {
        "format": FORMAT,
        "track": "open",
        **plan.as_fields(),
        "official": is_official(plan),
        "gate": "full",
        "localization": localization_of(plan),
        "hardware_hash": hashlib.sha256(RobotProfile.load(plan.settings.hardware).yaml.encode()).hexdigest(),
        "repeats": "to the bit" if plan.settings.backend == "mock" else "to the bit on one kind of processor",
        "library": library(plan.settings.backend),
        "episode_results": rows,
        "summary": summarize(plan.task, rows),
    }


def _key_of(episode: Episode) -> dict[str, Any]:
    named = {"scene": episode.scene, "index": episode.index, "seed": episode.seed}
    return named | {name: value for name in ("stratum", "category", "instruction") if (value := getattr(episode, name))}


def is_official(plan: Plan) -> bool:
    """Whether results may stand among robots': of one in official settings that knows no more than a robot does."""
    drives = plan.agent.kind != "yardstick" and not plan.quick
    return plan.settings.official and drives and not plan.agent.privileged


def localization_of(plan: Plan) -> str:
    """Where poses come from."""
    if plan.quick:
        return "a model"
    return "as the privileged agent chose" if plan.agent.privileged else "the robot's own"


def library(*backends: str) -> dict[str, str]:
    """Which 3we, with which engines, and on which machine."""
    import threewe

    used = {"mujoco": version("mujoco-core")} if "mujoco" in backends else {}
    return {
        "version": threewe.__version__,
        "commit": commit_of(Path(threewe.__file__).parent),
        "machine": machine(),
        **used,
    }


def machine() -> str:
    """The processor, and how many there are."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    models = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return f"{models[0] if models else platform.machine()}, {os.cpu_count()} CPUs"


def commit_of(package: Path) -> str:
    """Of the source tree that a package is in, or that its wheel was made from; empty where that is unknown."""
    root, noted = package.parents[1], package / "commit.txt"
    if not (root / ".git").exists():
        return noted.read_text() if noted.exists() else ""
    command = ["git", "describe", "--always", "--dirty", "--abbrev=10", "--exclude=*"]
    return subprocess.run(command, cwd=root, capture_output=True, text=True).stdout.strip()
