"""Lists of episodes that are frozen in files, so that everybody's figures are about the same ones."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from threewe._core import asset_directories, unknown_name
from threewe.errors import ConfigError
from threewe.gym.env import Env
from threewe.gym.vector import VectorEnv

Policy = Callable[[dict[str, NDArray[Any]]], NDArray[np.float32]]
"""Observations of many robots to their actions, (n, 3)."""


@dataclass(frozen=True)
class Episode:
    """One task: from a pose to a place, in the scene's frame."""

    scene: str
    index: int  # of `SceneTables.sample_episode`
    seed: int  # for all else that is drawn: people, noise
    start: tuple[float, float, float]  # x, y [m], theta [rad]
    goal: tuple[float, float]  # x, y [m]
    geodesic: float  # [m], from start to goal by the shortest path


class EpisodeSet(TypedDict):
    """What a file in assets/episodes holds: its definition, and the episodes that follow from it."""

    name: str
    hardware: str  # whose footprint the paths are for
    seed: int  # of `SceneTables.sample_episode`
    shortest: float  # [m], bounds of the geodesic length
    longest: float  # [m]
    straightness: float  # geodesic over straight length, at most
    episodes: list[Episode]


@dataclass(frozen=True)
class Outcome:
    """How an episode went, by the metrics of the task."""

    episode: Episode
    steps: int
    success: bool
    metrics: dict[str, float]


def load_episodes(name: str | Path) -> EpisodeSet:
    """A set by name, such as `reactive_v1`, or a file."""
    path = Path(name)
    if path.suffix != ".json":
        known = {file.stem: file for folder in asset_directories() for file in Path(folder).glob("episodes/*.json")}
        if str(name) not in known:
            raise ConfigError(unknown_name("set of episodes", str(name), sorted(known)))
        path = known[str(name)]
    content = json.loads(path.read_text())
    content["episodes"] = [
        Episode(scene, index, seed, tuple(start), tuple(goal), geodesic)
        for scene, listed in content["episodes"].items()
        for index, seed, start, goal, geodesic in listed
    ]
    return content  # type: ignore[no-any-return]


def evaluate(policy: Policy, episodes: Sequence[Episode], **options: Any) -> list[Outcome]:
    """Drives the episodes, each to its end; `options` are those of `VectorEnv`, or of `Env` with a `backend`.

    In the embedded simulator all are driven at once; on a backend one after the other, by a `Robot`: a policy that
    remembers is to be a new one for each. An episode is over when the task says so, or after `max_steps`. Its noise and
    people follow from its seed alone, so that the same policy has the same outcomes whatever else is on the list.
    """
    scenes = list(dict.fromkeys(episode.scene for episode in episodes))
    wanted = {"task": "navigation", "scene": scenes, **options}
    if options.get("backend") is not None:
        env = Env(**wanted)
        return [_drive(env, policy, episode) for episode in episodes]
    return _drive_all(VectorEnv(**wanted, num_envs=len(episodes), copy=False), policy, episodes)


def _drive(env: Env, policy: Policy, episode: Episode) -> Outcome:
    observation, _ = env.reset(seed=episode.seed, options=_place(episode))
    steps, over = 0, False
    while not over:
        action = policy({name: values[None] for name, values in observation.items()})[0]
        observation, _, terminated, truncated, info = env.step(action)
        steps, over = steps + 1, terminated or truncated
    return Outcome(episode, steps, info["success"], {name: float(info[name]) for name in env.metric_names})


def _drive_all(env: VectorEnv, policy: Policy, episodes: Sequence[Episode]) -> list[Outcome]:
    for i, episode in enumerate(episodes):
        only = np.arange(len(episodes)) == i
        seeds: list[int | None] = [episode.seed] * len(episodes)
        observations, _ = env.reset(seed=seeds, options={**_place(episode), "reset_mask": only})

    outcomes: dict[int, Outcome] = {}
    steps = 0
    while len(outcomes) < len(episodes):
        observations, _, terminated, truncated, infos = env.step(policy(observations))
        steps += 1
        for i in np.flatnonzero(terminated | truncated).tolist():
            if i not in outcomes:  # those that are done go on with other episodes, which nobody watches
                metrics = {name: float(infos[name][i]) for name in infos if not name.startswith("_")}
                outcomes[i] = Outcome(episodes[i], steps, bool(infos["success"][i]), metrics)
    return [outcomes[i] for i in range(len(episodes))]


def _place(episode: Episode) -> dict[str, Any]:
    return {"scene": episode.scene, "start": episode.start, "goal": episode.goal}
