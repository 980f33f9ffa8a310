"""Sets of episodes that are frozen in files, so that everyone's figures are about the same ones."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypedDict

from threewe._core import asset_directories, unknown_name
from threewe._files import read_text
from threewe.errors import ConfigError

FARTHEST = 1e6  # [m], and more than any other number of an episode
TASKS = ("navigation", "pointnav", "objectnav", "vln", "exploration")


@dataclass(frozen=True)
class Yardstick:
    """The baseline's drive of an episode: optimistic replanning, or nearest-frontier exploration."""

    success: float  # 1 where it reached the goal; of an exploration the share that it covered
    length: float  # [m]
    duration: float  # [s]


@dataclass(frozen=True)
class Episode:
    """One task: where a robot starts and what it is to do, in the scene's frame."""

    scene: str
    index: int  # of the sampler
    seed: int  # for all else that is drawn: people, noise
    start: tuple[float, float, float]  # x, y [m], theta [rad]
    goal: tuple[float, float] | None  # x, y [m], of a task with one; of VLN the end of the path
    geodesic: float  # [m] by the shortest path, from start to goal or to the nearest place of success; 0 without one
    category: str | None = None  # of what is looked for
    instruction: str | None = None  # of VLN, English
    stratum: str | None = None  # of length and directness, such as "5-9 detour"
    yardstick: Yardstick | None = None


@dataclass(frozen=True)
class Outcome:
    """How an episode went, by the metrics of the task."""

    episode: Episode
    steps: int
    success: bool
    metrics: dict[str, float]


class EpisodeSet(TypedDict):
    """What a file in assets/episodes holds: its definition, and the episodes that follow from it."""

    name: str
    task: str  # "navigation", "pointnav", "objectnav", "vln" or "exploration"
    split: str  # "val", "test", "generated"; empty for a set without splits
    hardware: str  # whose footprint the paths are for
    seed: int  # of the sampler
    shortest: float  # [m], bounds of the geodesic length
    longest: float  # [m]
    straightness: float  # geodesic over straight length, at most
    lacking: dict[str, list[str]]  # strata or categories that a scene has too few of, by scene
    commitment: str  # SHA-256 of the secret that generated buildings are drawn from; empty for other splits
    episodes: list[Episode]


OPTIONAL: Final[dict[str, Any]] = {
    "task": "navigation",
    "split": "",
    "shortest": 0.0,
    "longest": FARTHEST,
    "straightness": FARTHEST,
    "lacking": {},
    "commitment": "",
    "columns": ["index", "seed", "start", "goal", "geodesic"],
}
"""Fields that a file may leave out, and what they are then. `columns` says what a row holds, in its order."""


def load_episodes(name: str | Path) -> EpisodeSet:
    """A set by name, such as `pointnav_val_v1`, or a file. Raises ConfigError naming file and field."""
    path = find_episodes(name)
    text = read_text(path)
    try:
        content = json.loads(text, parse_constant=_no_number)
    except RecursionError:
        raise ConfigError(f"{path}: nested too deeply for a set of episodes") from None
    except ValueError as error:
        raise ConfigError(f"{path}: {error}") from None
    names = [*EpisodeSet.__annotations__, "columns"]
    fields = {**OPTIONAL, **_fields(path, "the set", content, names, OPTIONAL)}
    task = _text(path, "task", fields["task"])
    if task not in TASKS:
        raise ConfigError(f"{path}: {unknown_name('task', task, list(TASKS))}")
    listed = fields["episodes"]
    if not isinstance(listed, dict) or not all(isinstance(rows, list) for rows in listed.values()):
        raise ConfigError(f"{path}: episodes: expected lists of episodes, by scene")
    columns = _columns(path, fields["columns"])
    return {
        "name": _text(path, "name", fields["name"]),
        "task": task,
        "split": _text(path, "split", fields["split"]),
        "hardware": _text(path, "hardware", fields["hardware"]),
        "seed": _whole(path, "seed", fields["seed"]),
        "shortest": _number(path, "shortest", fields["shortest"]),
        "longest": _number(path, "longest", fields["longest"]),
        "straightness": _number(path, "straightness", fields["straightness"]),
        "lacking": _lacking(path, fields["lacking"]),
        "commitment": _text(path, "commitment", fields["commitment"]),
        "episodes": [
            _episode(path, scene, columns, f"episodes.{scene}[{i}]", row)
            for scene, rows in listed.items()
            for i, row in enumerate(rows)
        ],
    }


def find_episodes(name: str | Path) -> Path:
    """The file of a set. Raises ConfigError for an unknown name, with the nearest right one."""
    path = Path(name)
    if path.suffix == ".json":
        return path
    known = {file.stem: file for folder in asset_directories() for file in Path(folder).glob("episodes/*.json")}
    if str(name) not in known:
        raise ConfigError(unknown_name("set of episodes", str(name), sorted(known)))
    return known[str(name)]


def digest(path: Path) -> str:
    """SHA-256 of a file, as the name of its bytes."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def to_json(episodes: EpisodeSet, columns: list[str]) -> str:
    """The text of a file, one line for each episode."""
    definition = {key: value for key, value in episodes.items() if key != "episodes" and value != OPTIONAL.get(key)}
    parts = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in definition.items()]
    if columns != OPTIONAL["columns"]:
        parts.append(f'  "columns": {json.dumps(columns)}')
    scenes = []
    for scene in dict.fromkeys(episode.scene for episode in episodes["episodes"]):
        rows = [_row(episode, columns) for episode in episodes["episodes"] if episode.scene == scene]
        lines = ",\n".join(f"      {json.dumps(row)}" for row in rows)
        scenes.append(f"    {json.dumps(scene)}: [\n{lines}\n    ]")
    parts.append('  "episodes": {\n' + ",\n".join(scenes) + "\n  }")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _row(episode: Episode, columns: list[str]) -> list[Any]:
    values: dict[str, Any] = {**vars(episode)}
    if episode.yardstick:
        values["yardstick"] = [episode.yardstick.success, episode.yardstick.length, episode.yardstick.duration]
    return [values[column] for column in columns]


def _episode(path: Path, scene: str, columns: list[str], place: str, row: Any) -> Episode:
    if not isinstance(row, list) or len(row) != len(columns):
        raise ConfigError(f"{path}: {place}: expected [{', '.join(columns)}]")
    values: dict[str, Any] = {"goal": None, "geodesic": 0.0}
    for column, value in zip(columns, row, strict=True):
        values[column] = READERS[column](path, f"{place} {column}", value)
    return Episode(scene=scene, **values)


def _pose(path: Path, place: str, value: Any) -> tuple[float, float, float]:
    x, y, theta = _numbers(path, place, value, 3)
    return x, y, theta


def _point(path: Path, place: str, value: Any) -> tuple[float, float]:
    x, y = _numbers(path, place, value, 2)
    return x, y


def _yardstick(path: Path, place: str, value: Any) -> Yardstick:
    return Yardstick(*_numbers(path, place, value, 3))


def _columns(path: Path, value: Any) -> list[str]:
    if not isinstance(value, list) or not value:
        raise ConfigError(f"{path}: columns: expected a list of names")
    for name in value:
        if name not in READERS:
            raise ConfigError(f"{path}: columns: {unknown_name('column', str(name), sorted(READERS))}")
    for name in ("index", "seed", "start"):
        if name not in value:
            raise ConfigError(f"{path}: columns: missing column {name!r}")
    if len(set(value)) != len(value):
        raise ConfigError(f"{path}: columns: each name may be there once")
    return value


def _lacking(path: Path, value: Any) -> dict[str, list[str]]:
    if not isinstance(value, dict) or not all(isinstance(names, list) for names in value.values()):
        raise ConfigError(f"{path}: lacking: expected lists of names, by scene")
    return {scene: [_text(path, f"lacking.{scene}", name) for name in names] for scene, names in value.items()}


def _fields(path: Path, place: str, value: Any, names: Iterable[str], optional: Iterable[str] = ()) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ConfigError(f"{path}: {place}: expected fields by their names")
    for name in names:
        if name not in value and name not in optional:
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


READERS: dict[str, Callable[[Path, str, Any], Any]] = {
    "index": _whole,
    "seed": _whole,
    "start": _pose,
    "goal": _point,
    "geodesic": _number,
    "category": _text,
    "instruction": _text,
    "stratum": _text,
    "yardstick": _yardstick,
}
"""How the value of each column is read."""
