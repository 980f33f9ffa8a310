"""Sim-to-sim transfer of a policy: its success on another backend over that on the one that it comes from."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from threewe.benchmark.attempt import Settings
from threewe.benchmark.episodes import Episode
from threewe.benchmark.run import EPISODE_LIMIT, MEMORY, OnDone, Plan, library, plan_run, run
from threewe.benchmark.statistics import wilson
from threewe.errors import ConfigError

FORMAT = "threewe-transfer/1"


@dataclass(frozen=True)
class TransferPlan:
    """Each episode of the source with several seeds of noise, and the first ones of these on the target."""

    source: Plan
    target: Plan
    on_source: tuple[Episode, ...]
    on_target: tuple[Episode, ...]  # each is one of the source's, with its first seed
    seeds: int


def plan_transfer(
    policy: str, source: str, target: str, *, task: str, split: str, scenes: Sequence[str], episodes: int, seeds: int,
    matched: int, settings: Settings,
) -> TransferPlan:  # fmt: skip
    """The paper's protocol: `episodes` x `seeds` on the source, `matched` of them on the target.

    Episodes are spread evenly over the scenes. Raises ConfigError as `plan_run`.
    """
    if matched > episodes:
        raise ConfigError(f"target episodes: {matched} cannot be matched with {episodes} of the source")
    plan, listed = plan_run(
        task, policy, split=split, scenes=scenes, episodes=episodes, settings=replace(settings, backend=source)
    )
    if plan.agent.kind == "yardstick":
        raise ConfigError(f"policy: {policy} drives no robot")
    chosen = _spread(listed, plan.scenes, episodes)
    on_source = tuple(with_noise(episode, seed) for seed in range(seeds) for episode in chosen)
    return TransferPlan(
        plan, replace(plan, settings=replace(settings, backend=target)), on_source, on_source[:matched], seeds
    )


def run_transfer(
    plan: TransferPlan,
    journal: Path,
    *,
    workers: int = 1,
    limit: float = EPISODE_LIMIT,
    memory: int = MEMORY,
    on_done: OnDone = lambda *_: None,
) -> dict[str, Any]:
    """Drives both, and returns what came of it. What has finished is in two journals, from which it goes on."""
    count = len(plan.on_source)
    total = count + len(plan.on_target)
    parts: dict[str, list[dict[str, Any]]] = {}
    for name, part, episodes, before in (
        ("source", plan.source, plan.on_source, 0),
        ("target", plan.target, plan.on_target, count),
    ):
        tell = _counted(on_done, before, total)
        outcomes = run(
            part,
            episodes,
            journal.with_suffix(f".{name}.jsonl"),
            workers=workers,
            limit=limit,
            memory=memory,
            on_done=tell,
        )
        parts[name] = [
            {
                "scene": episode.scene,
                "index": episode.index,
                "seed": episode.seed,
                "success": outcome["metrics"]["success"],
                "failure": outcome["failure"],
            }
            for episode, outcome in zip(episodes, outcomes, strict=True)
        ]
    return {
        "format": FORMAT,
        **_described(plan),
        "library": library(plan.source.settings.backend, plan.target.settings.backend),
        **parts,
        "summary": transfer_summary(**parts),
    }


def transfer_summary(source: Sequence[dict[str, Any]], target: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Success on either, and the ratio, with 95 % intervals."""
    hits = [sum(row["success"] > 0.5 for row in rows) for rows in (source, target)]
    counts = len(source), len(target)
    figures: dict[str, Any] = {}
    for name, won, count in zip(("source", "target"), hits, counts, strict=True):
        low, high = wilson(won, count)
        figures[name] = {"value": won / count, "low": low, "high": high, "count": count}
    low, high = ratio_interval((hits[1], counts[1]), (hits[0], counts[0]))
    ratio = figures["target"]["value"] / figures["source"]["value"] if hits[0] else math.nan
    matched = {(row["scene"], row["index"], row["seed"]): row["success"] for row in source}
    pairs = [(matched[row["scene"], row["index"], row["seed"]], row["success"]) for row in target]
    figures["ratio"] = {"value": ratio, "low": low, "high": high, "count": counts[1]} if hits[0] else None
    figures["matched"] = {"source": sum(own for own, _ in pairs), "target": sum(other for _, other in pairs)}
    return figures


def ratio_interval(first: tuple[int, int], second: tuple[int, int]) -> tuple[float, float]:
    """The 95 % interval of the ratio of two proportions, hits and count each, from their Wilson intervals.

    MOVER-R (A. Donner and G. Zou, 2012, Statistical Methods in Medical Research 21).
    """
    p, q = first[0] / first[1], second[0] / second[1]
    (p_low, p_high), (q_low, q_high) = wilson(*first), wilson(*second)

    def bound(own: float, other: float, sign: float) -> float:
        scale = other * (2.0 * q - other)
        root = math.sqrt(max((p * q) ** 2 - own * (2.0 * p - own) * scale, 0.0))
        return (p * q + sign * root) / scale if scale > 0.0 else math.inf

    return max(0.0, bound(p_low, q_high, -1.0)), bound(p_high, q_low, 1.0)


def _described(plan: TransferPlan) -> dict[str, Any]:
    fields = plan.source.as_fields()
    settings = fields.pop("settings")
    return {
        **fields,
        "settings": {name: value for name, value in settings.items() if name != "backend"},
        "source_backend": plan.source.settings.backend,
        "target_backend": plan.target.settings.backend,
        "seeds": plan.seeds,
    }


def _spread(episodes: Sequence[Episode], scenes: Sequence[str], count: int) -> list[Episode]:
    """So many of them, from each scene in turn."""
    by_scene = [[episode for episode in episodes if episode.scene == scene] for scene in scenes]
    longest = max(map(len, by_scene))
    in_turns = [some[i] for i in range(longest) for some in by_scene if i < len(some)]
    if len(in_turns) < count:
        raise ConfigError(f"episodes: {count} were asked for, there are {len(in_turns)}")
    return in_turns[:count]


def with_noise(episode: Episode, seed: int) -> Episode:
    """The same episode with other noise; with seed 0 as it was frozen."""
    if seed == 0:
        return episode
    drawn = hashlib.sha256(f"{episode.seed}/{seed}".encode()).digest()
    return replace(episode, seed=int.from_bytes(drawn[:8], "little"))


def _counted(on_done: OnDone, before: int, total: int) -> Callable[..., object]:
    return lambda count, _, episode, finished: on_done(before + count, total, episode, finished)
