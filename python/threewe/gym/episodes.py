"""Drives of a policy through frozen episodes, in the native batch or by a `Robot`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe.benchmark.episodes import Episode, Outcome
from threewe.gym.env import Env
from threewe.gym.vector import VectorEnv

Policy = Callable[[dict[str, NDArray[Any]]], NDArray[np.float32]]
"""Observations of many robots to their actions, (n, 3)."""


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
            if i not in outcomes:  # those that are done go on with other episodes, which are not watched
                metrics = {name: float(infos[name][i]) for name in infos if not name.startswith("_")}
                outcomes[i] = Outcome(episodes[i], steps, bool(infos["success"][i]), metrics)
    return [outcomes[i] for i in range(len(episodes))]


def _place(episode: Episode) -> dict[str, Any]:
    place = {"scene": episode.scene, "start": episode.start, "goal": episode.goal, "object_goal": episode.category}
    return {name: value for name, value in place.items() if value is not None}
