"""Verification of bundles: every episode is replayed below the gate, and every claim computed again.

It shows that these commands give this result, not that sensors alone chose them: a result that was verified is on the
open track all the same.
"""

from __future__ import annotations

import base64
import hashlib
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from threewe._core import OccupancyGrid, RobotProfile
from threewe.benchmark.agents import Identity, file_of, has_source, identify
from threewe.benchmark.attempt import SLOWEST, Settings, as_base64, attempt, from_base64, replay
from threewe.benchmark.bundle import BundleError, read_bundle, text_of
from threewe.benchmark.claims import LONGEST_TEXT, Claim, claims_of, require_actions, require_drivable
from threewe.benchmark.episodes import Episode
from threewe.benchmark.run import EPISODE_LIMIT, FORMAT, MEMORY, OnDone, Plan, results_of
from threewe.benchmark.run import run as run_plan
from threewe.benchmark.runner import Finished, Job, Result, run_jobs
from threewe.benchmark.sampling import training_episodes
from threewe.benchmark.tasks import TASKS, TICK
from threewe.errors import ConfigError

BACKENDS = ("mock", "mujoco")


@dataclass(frozen=True)
class Verified:
    """What was replayed."""

    plan: Plan
    results: dict[str, Any]
    seconds: float  # of CPU, of all replays


def verify_bundle(
    path: Path,
    *,
    workers: int = 1,
    episode_file: Path | None = None,
    talk: bool = False,
    on_done: Callable[[int, int], object] = lambda *_: None,
) -> Verified:
    """Replays every episode of a bundle. Raises BundleError that says what is wrong, and where it differs first.

    Args:
        path: the bundle.
        workers: processes at a time.
        episode_file: the set of episodes, where it is not one that comes with 3we, as held-out buildings are.
        talk: also repeats each conversation with a model, without its server: the robot must do the same to the bit.
        on_done: called with how many have been replayed, and how many there are.
    """
    bundle = read_bundle(path)
    plan = plan_of(bundle.results)
    claims = claims_of(bundle, plan, episode_file)
    profile = RobotProfile.load(plan.settings.hardware)
    for claim in claims:
        require_drivable(claim, profile, TASKS[plan.task].time_limit(claim.episode))
        require_actions(claim, plan)
    replayed = _replay_all(plan, claims, workers, on_done)
    for claim, finished in zip(claims, replayed, strict=True):
        if finished.failure:
            raise BundleError(f"{claim.name}: cannot be replayed: {finished.failure.splitlines()[-1]}")
        require_same(claim, finished.result, plan.settings.backend)
    require_results(bundle.results, plan, claims, [finished.result for finished in replayed])
    if talk:
        _repeat_talks(plan, claims, workers)
    return Verified(plan, bundle.results, sum(finished.seconds for finished in replayed))


def plan_of(results: dict[str, Any]) -> Plan:
    """What results claim to be of. Raises BundleError for what no official run has."""
    if results.get("format") != FORMAT:
        raise BundleError(f"format: expected {FORMAT!r}, got {results.get('format')!r}")
    try:
        agent = Identity(**results["agent"])
        settings = Settings(**results["settings"])
        names = [results["task"], results["episode_set"], results["episode_hash"], *results["scenes"]]
        plan = Plan(
            results["task"],
            agent,
            results["episode_set"],
            results["episode_hash"],
            tuple(results["scenes"]),
            results["episodes"],
            settings,
        )
    except (KeyError, TypeError) as error:
        raise BundleError(f"results.json: not as a run writes it: {error}") from None
    if not _are_names(*names, agent.name, agent.source):
        raise BundleError("results.json: a name is no text, or too long")
    if not _is_number(settings.control_rate) or settings.control_rate < SLOWEST:
        raise BundleError(f"settings: control_rate: expected {SLOWEST:g} Hz or more")
    if not isinstance(settings.seed, int) or isinstance(settings.seed, bool):
        raise BundleError("settings: seed: expected a whole number")
    if plan.task not in TASKS:
        raise BundleError(f"task: there is no {plan.task!r}")
    _require_identity(plan.task, agent)
    if not isinstance(plan.episodes, int) or isinstance(plan.episodes, bool) or plan.episodes < 1:
        raise BundleError("episodes: expected a whole number of 1 or more")
    for name in ("hardware", "noise", "randomization"):
        value, official = getattr(settings, name), getattr(Settings(), name)
        if value != official:
            raise BundleError(f"settings: {name} {value!r} is not that of the frozen episodes, {official!r}")
    if settings.backend not in BACKENDS:
        raise BundleError(f"settings: backend {settings.backend!r} cannot be replayed")
    return plan


def _require_identity(task: str, agent: Identity) -> None:
    """A shipped agent is what it is known to be here; what another says of itself is of the right form."""
    if not isinstance(agent.privileged, bool):
        raise BundleError("agent: privileged: expected true or false")
    if agent.kind not in ("run", "act"):
        raise BundleError(f"agent: one of kind {agent.kind!r} drives no robot")
    if has_source(agent.name):
        if not re.fullmatch("[0-9a-f]{64}", agent.source):
            raise BundleError("agent: source: expected the SHA-256 of what it was read from")
        return
    try:
        known = identify(task, agent.name)
    except ConfigError as error:
        raise BundleError(str(error)) from None
    if agent != known:
        raise BundleError(f"agent: the {agent.name} that comes with 3we is {known}, the bundle has {agent}")


def _are_names(*values: object) -> bool:
    return all(isinstance(text, str) and len(text) <= LONGEST_TEXT for text in values)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _replay_all(
    plan: Plan, claims: Sequence[Claim], workers: int, on_done: Callable[[int, int], object]
) -> list[Finished]:
    jobs = [
        Job(
            claim.name,
            _replay,
            {
                "task": plan.task,
                "episode": claim.episode,
                "settings": plan.settings,
                "end": claim.row["end"],
                "commands": as_base64(claim.commands),
                "grid": claim.grid,
            },
            EPISODE_LIMIT,
        )
        for claim in claims
    ]
    count = 0

    def done(_: Job, __: Finished) -> None:
        nonlocal count
        count += 1
        on_done(count, len(jobs))

    return run_jobs(jobs, workers, on_done=done)


def _repeat_talks(plan: Plan, claims: Sequence[Claim], workers: int) -> None:
    """Raises BundleError where a robot, given a conversation as it was, leaves the way of the claim."""
    talks = [(claim, base64.b64encode(claim.talk).decode()) for claim in claims if claim.talk is not None]
    if not talks:
        raise BundleError("talk: no conversation with a model is in the bundle")
    jobs = [
        Job(claim.name, attempt, {"task_name": plan.task, "episode": claim.episode, "agent_name": plan.agent.name,
             "settings": plan.settings, "talk": talk}, EPISODE_LIMIT)
        for claim, talk in talks
    ]  # fmt: skip
    for (claim, _), finished in zip(talks, run_jobs(jobs, workers), strict=True):
        if finished.failure:
            raise BundleError(f"{claim.name}: talk: cannot be repeated: {finished.failure.splitlines()[-1]}")
        again = from_base64(finished.result["replayed"]["commands"], "<f8")
        least = min(len(again), len(claim.commands))
        differs = np.flatnonzero((again[:least] != claim.commands[:least]).any(axis=1))
        if len(differs) or len(again) != len(claim.commands):
            at = (differs[0] if len(differs) else least) * TICK
            raise BundleError(f"{claim.name}: talk: given the same answers, the robot leaves the log at {at:.2f} s")


def _replay(
    task: str, episode: Episode, settings: Settings, end: str, commands: str, grid: OccupancyGrid | None
) -> Result:
    again = replay(task, episode, settings, end, from_base64(commands, "<f8"), grid)
    return {name: value for name, value in again.items() if name != "replayed"}


def require_same(claim: Claim, again: Result, backend: str) -> None:
    """The replay is what is claimed, to the bit."""
    elsewhere = "; MuJoCo repeats to the bit on one kind of processor only" if backend == "mujoco" else ""
    there, wanted = claim.row.get("trajectory"), again["trajectory"]
    if not isinstance(there, list) or len(there) != len(wanted):
        raise BundleError(f"{claim.name}: the trajectory has another length than its replay")
    for i, (pose, replayed) in enumerate(zip(there, wanted, strict=True)):
        if not same(pose, replayed):
            at = min(i * 10, max(again["ticks"] - 1, 0)) * TICK
            raise BundleError(
                f"{claim.name}: differs from its replay at {at:.2f} s: {pose}, replayed {replayed}{elsewhere}"
            )
    metrics = claim.row.get("metrics")
    if not isinstance(metrics, dict) or sorted(metrics) != sorted(again["metrics"]):
        raise BundleError(f"{claim.name}: metrics: expected {', '.join(sorted(again['metrics']))}")
    for name, value in again["metrics"].items():
        if not same(metrics[name], value):
            raise BundleError(f"{claim.name}: {name} is {value} by its replay, {metrics[name]} by the claim{elsewhere}")


def same(claimed: Any, value: Any) -> bool:
    """To the bit, for numbers and lists of them."""
    if isinstance(value, list):
        return isinstance(claimed, list) and len(claimed) == len(value) and all(map(same, claimed, value))
    return _is_number(claimed) and claimed == value and math.copysign(1.0, claimed) == math.copysign(1.0, value)


def require_results(results: dict[str, Any], plan: Plan, claims: Sequence[Claim], replayed: Sequence[Result]) -> None:
    """All that follows from the episodes is as it follows: summary, official or not."""
    outcomes = [{**one, "failure": claim.row["failure"]} for claim, one in zip(claims, replayed, strict=True)]
    wanted = results_of(plan, [claim.episode for claim in claims], outcomes)
    known, named = wanted["library"], results.get("library")
    if not isinstance(named, dict) or sorted(named) != sorted(known) or not _are_names(*named.values()):
        raise BundleError(f"library: expected {', '.join(known)}, each a text")
    wanted["library"] = named
    for name in sorted({*wanted, *results}):
        if name not in results or name not in wanted or text_of({"": results[name]}) != text_of({"": wanted[name]}):
            raise BundleError(f"{name}: not what follows from the episodes")


def rerun_policy(
    verified: Verified, *, seed: int, episodes: int = 20, workers: int = 1, memory: int = MEMORY, folder: Path,
    on_done: OnDone = lambda *_: None,
) -> dict[str, Any]:  # fmt: skip
    """Drives the agent of a bundle through new episodes, in buildings that are drawn from a seed.

    A log that was written by hand replays as well as any; the policy that is said to have written it has to earn its
    figures again. Nothing is imported that is not the source which the bundle names, by its hash. It is imported, made
    and run in a process with limits on time and memory, which is no wall against hostile code: run a third party's
    policy in a container.

    Raises BundleError where the agent here is another than the bundle names, or cannot be made.
    """
    plan, agent = verified.plan, verified.plan.agent
    _require_agent(plan.task, agent, memory)
    new = list(islice(training_episodes(plan.task, seed), episodes))
    hashed = hashlib.sha256(repr(new).encode()).hexdigest()
    scenes = tuple(dict.fromkeys(episode.scene for episode in new))
    again = Plan(plan.task, agent, f"{plan.task}_rerun_{seed}", hashed, scenes, episodes, plan.settings)
    outcomes = run_plan(again, new, folder / "rerun.jsonl", workers=workers, memory=memory, on_done=on_done)
    return results_of(again, new, outcomes)


def _require_agent(task: str, agent: Identity, memory: int) -> None:
    """The agent is here as the bundle names it: by its source before any of it runs, then by what it says of itself."""
    another = f"agent: {agent.name} here is another than in the bundle"
    file = file_of(agent.name)
    if file is not None and hashlib.sha256(file.read_bytes()).hexdigest() != agent.source:
        raise BundleError(f"{another}, by its source")
    job = Job(agent.name, _identified, {"task": task, "name": agent.name}, EPISODE_LIMIT)
    [finished] = run_jobs([job], 1, memory=memory)
    if finished.failure:
        raise BundleError(f"agent: {agent.name}: cannot be made here: {finished.failure.splitlines()[-1]}")
    if Identity(**finished.result) != agent:
        raise BundleError(f"{another}: {finished.result}")


def _identified(task: str, name: str) -> Result:
    return asdict(identify(task, name))
