"""Lists of episodes that are frozen in files, so that everybody's figures are about the same ones."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from threewe._core import asset_directories, unknown_name
from threewe._files import read_text
from threewe.errors import ConfigError
from threewe.gym.env import Env
from threewe.gym.vector import VectorEnv

FARTHEST = 1e6  # [m], and more than any other number of an episode

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
    text = read_text(path)
    try:
        content = json.loads(text, parse_constant=_no_number)
    except RecursionError:
        raise ConfigError(f"{path}: nested too deeply for a set of episodes") from None
    except ValueError as error:
        raise ConfigError(f"{path}: {error}") from None
    fields = _fields(path, "the set", content, EpisodeSet.__annotations__)
    listed = fields["episodes"]
    if not isinstance(listed, dict) or not all(isinstance(rows, list) for rows in listed.values()):
        raise ConfigError(f"{path}: episodes: expected lists of episodes, by scene")
    return {
        "name": _text(path, "name", fields["name"]),
        "hardware": _text(path, "hardware", fields["hardware"]),
        "seed": _whole(path, "seed", fields["seed"]),
        "shortest": _number(path, "shortest", fields["shortest"]),
        "longest": _number(path, "longest", fields["longest"]),
        "straightness": _number(path, "straightness", fields["straightness"]),
        "episodes": [
            _episode(path, scene, f"episodes.{scene}[{i}]", row)
            for scene, rows in listed.items()
            for i, row in enumerate(rows)
        ],
    }


def _episode(path: Path, scene: str, place: str, row: Any) -> Episode:
    if not isinstance(row, list) or len(row) != 5:
        raise ConfigError(f"{path}: {place}: expected [index, seed, [x, y, theta], [x, y], geodesic]")
    index, seed, start, goal, geodesic = row
    x, y, theta = _numbers(path, f"{place} start", start, 3)
    goal_x, goal_y = _numbers(path, f"{place} goal", goal, 2)
    length = _number(path, f"{place} geodesic", geodesic)
    numbers = _whole(path, f"{place} index", index), _whole(path, f"{place} seed", seed)
    return Episode(scene, *numbers, (x, y, theta), (goal_x, goal_y), length)


def _fields(path: Path, place: str, value: Any, names: Iterable[str]) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ConfigError(f"{path}: {place}: expected fields by their names")
    for name in names:
        if name not in value:
            raise ConfigError(f"{path}: missing field {name!r}")
    for name in value:
        if name not in names:
            raise ConfigError(f"{path}: {unknown_name('field', name, sorted(names))}")
    return value


def _text(path: Path, place: str, value: Any) -> str:
    if not isinstance(value, str):
        raise ConfigError(f"{path}: {place}: expected text")
    return value


def _whole(path: Path, place: str, value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < 2**64:
        raise ConfigError(f"{path}: {place}: expected a whole number in [0, 2**64)")
    return value


def _number(path: Path, place: str, value: Any) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not abs(value) <= FARTHEST:
        raise ConfigError(f"{path}: {place}: expected a number in [{-FARTHEST:g}, {FARTHEST:g}]")
    return float(value)


def _numbers(path: Path, place: str, values: Any, count: int) -> list[float]:
    if not isinstance(values, list) or len(values) != count:
        raise ConfigError(f"{path}: {place}: expected {count} numbers")
    return [_number(path, place, value) for value in values]


def _no_number(text: str) -> float:
    raise ValueError(f"{text} is no number of an episode")


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
    return {"scene": episode.scene, "start": episode.start, "goal": episode.goal}
