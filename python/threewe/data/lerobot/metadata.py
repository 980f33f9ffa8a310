"""What a dataset's `meta` folder says of its tasks and episodes, for both versions, checked as data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from threewe.data.lerobot.info import Info, read_json, read_json_lines
from threewe.data.lerobot.layout import EpisodeRow
from threewe.data.lerobot.parquet_file import ParquetTable
from threewe.data.lerobot.places import Template, inside
from threewe.data.lerobot.stats import QUANTILES, Stats
from threewe.errors import ConfigError

LONGEST_TEXT = 100_000
LONGEST_EPISODE = 2**24
BASICS = ("min", "max", "mean", "std", "count")


def read_tasks(root: Path, info: Info) -> list[str]:
    """The texts of the tasks, by number. Raises ConfigError."""
    if info.version == "v3.0":
        table = ParquetTable(inside(root, "meta/tasks.parquet"))
        path = table.path
        if table.rows != info.total_tasks:
            raise ConfigError(f"{path}: {table.rows} tasks; meta/info.json says {info.total_tasks}")
        numbers = table.numbers("task_index").tolist()
        name = "task" if "task" in table.schema.names else "__index_level_0__"  # of pandas 3
        table.require([name])
        texts = table.read([name]).column(name).to_pylist()
    else:
        path = inside(root, "meta/tasks.jsonl")
        rows = read_json_lines(path)
        numbers, texts = [row.get("task_index") for row in rows], [row.get("task") for row in rows]
    if numbers != list(range(len(numbers))):
        raise ConfigError(f"{path}: task_index must count from 0, not {numbers!r:.60}")
    if len(texts) != info.total_tasks:
        raise ConfigError(f"{path}: {len(texts)} tasks; meta/info.json says {info.total_tasks}")
    return [require_text(text, f"{path}: task {number}") for number, text in enumerate(texts)]


def read_episodes(root: Path, info: Info) -> list[EpisodeRow]:
    """All episodes in order. Raises ConfigError that names file and row."""
    rows = read_episodes_v30(root, info) if info.version == "v3.0" else read_episodes_v21(root)
    where = root / ("meta/episodes" if info.version == "v3.0" else "meta/episodes.jsonl")
    if [row.index for row in rows] != list(range(len(rows))):
        found = next(i for i, row in enumerate(rows) if row.index != i)
        raise ConfigError(f"{where}: row {found}: episode_index {rows[found].index}; it must be {found}")
    if len(rows) != info.total_episodes:
        raise ConfigError(f"{where}: {len(rows)} episodes; meta/info.json says {info.total_episodes}")
    start = 0
    for row in rows:
        if info.version == "v3.0" and row.start != start:
            raise ConfigError(f"{where}: row {row.index}: dataset_from_index {row.start}; it must be {start}")
        row.start, start = start, start + row.length
    if start != info.total_frames:
        raise ConfigError(f"{where}: lengths add up to {start}; meta/info.json says {info.total_frames} frames")
    if info.version == "v3.0":
        for row in rows:
            check_places(row, info, f"{where}: row {row.index}")
    return rows


def read_episodes_v30(root: Path, info: Info) -> list[EpisodeRow]:
    """From `meta/episodes/*/*.parquet`."""
    rows: list[EpisodeRow] = []
    for table in episode_tables(root):
        table.require(["episode_index", "tasks", "length", "dataset_from_index", "dataset_to_index"])
        if len(rows) + table.rows > info.total_episodes:
            there = f"{len(rows) + table.rows} episodes and more"
            raise ConfigError(f"{table.path}: {there}; meta/info.json says {info.total_episodes}")
        names = [name for name in table.schema.names if not name.startswith("stats/")]
        for batch in table.pieces(names):
            for entry in batch.to_pylist():
                rows.append(parse_row(entry, f"{table.path}: row {len(rows)}"))
    return rows


def read_episodes_v21(root: Path) -> list[EpisodeRow]:
    """From `meta/episodes.jsonl`."""
    path = inside(root, "meta/episodes.jsonl")
    return [parse_row(entry, f"{path}:{line}") for line, entry in enumerate(read_json_lines(path), 1)]


def parse_row(entry: Mapping[str, Any], where: str) -> EpisodeRow:
    """An episode's row without its statistics. Raises ConfigError."""
    index, length = (count(entry, name, where, LONGEST_EPISODE) for name in ("episode_index", "length"))
    tasks = entry.get("tasks")
    if not isinstance(tasks, list):
        raise ConfigError(f"{where}: tasks must be a list of texts, not {tasks!r:.60}")
    if not length:
        raise ConfigError(f"{where}: length 0; an episode has at least a frame")
    start = count(entry, "dataset_from_index", where, 2**40) if "dataset_from_index" in entry else 0
    if entry.get("dataset_to_index", start + length) != start + length:
        wrong = entry["dataset_to_index"]
        raise ConfigError(f"{where}: dataset_to_index {wrong!r:.40}; with {length} frames it must be {start + length}")
    places = {name: value for name, value in entry.items() if name.startswith(("data/", "videos/", "dataset_"))}
    return EpisodeRow(index, [require_text(task, where) for task in tasks], length, start, {}, places)


def check_places(row: EpisodeRow, info: Info, where: str) -> None:
    """Raises ConfigError where files or times of an episode are no numbers, or its video has another length."""
    for name in ["data", *(f"videos/{camera}" for camera in info.cameras)]:
        count(row.places, f"{name}/chunk_index", where, 10_000_000)
        count(row.places, f"{name}/file_index", where, 10_000_000)
    for camera in info.cameras:
        begin, end = (row.places.get(f"videos/{camera}/{edge}_timestamp", math.nan) for edge in ("from", "to"))
        if not all(isinstance(time, float) and math.isfinite(time) and 0 <= time < 2**40 for time in (begin, end)):
            raise ConfigError(f"{where}: {camera}: from {begin!r:.40} to {end!r:.40} are no times in seconds")
        if abs(begin * info.fps - round(begin * info.fps)) > 0.02:
            raise ConfigError(f"{where}: {camera}: from {begin:g} s, where no frame of {info.fps} a second begins")


def read_stats_v21(root: Path) -> dict[Any, Any]:
    """The statistics of all episodes by their numbers, as they are in the file. Raises ConfigError."""
    if not (root / "meta/episodes_stats.jsonl").exists():
        return {}
    lines = read_json_lines(inside(root, "meta/episodes_stats.jsonl"))
    return {line.get("episode_index"): line.get("stats") for line in lines if type(line.get("episode_index")) is int}


def episode_tables(root: Path) -> list[ParquetTable]:
    """The files of `meta/episodes` in order. Raises ConfigError."""
    folder = root / "meta/episodes"
    paths = sorted(folder.glob("*/*.parquet"))
    if not paths:
        raise ConfigError(f"{folder}: no Parquet file in it")
    return [ParquetTable(inside(root, path.relative_to(root).as_posix())) for path in paths]


def read_stats(tables: Sequence[ParquetTable], info: Info, index: int) -> dict[str, Stats]:
    """The statistics of one episode of v3.0; empty where there are none. Raises ConfigError."""
    position = 0
    for table in tables:
        if index < position + table.rows:
            names = [name for name in table.schema.names if name.startswith("stats/")]
            if not names:
                return {}
            (row,) = table.read(names, index - position, index - position + 1).to_pylist()
            nested: dict[str, dict[str, Any]] = {}
            for name, value in row.items():
                feature, _, key = name.removeprefix("stats/").rpartition("/")
                nested.setdefault(feature, {})[key] = value
            return parse_stats(nested, info, f"{table.path}: row {index}")
        position += table.rows
    return {}


def read_total_stats(root: Path, info: Info) -> dict[str, Stats]:
    """`meta/stats.json`. Raises ConfigError."""
    path = inside(root, "meta/stats.json")
    return parse_stats(read_json(path), info, str(path))


def parse_stats(entry: Any, info: Info, where: str) -> dict[str, Stats]:
    """Statistics of features as arrays of doubles. Raises ConfigError."""
    if not isinstance(entry, Mapping):
        raise ConfigError(f"{where}: stats must be a mapping of features, not {entry!r:.60}")
    stats: dict[str, Stats] = {}
    for name, values in entry.items():
        if name not in info.features:
            raise ConfigError(f"{where}: stats of {name!r:.80}, which is no feature")
        if not isinstance(values, Mapping) or any(values.get(key) is None for key in BASICS):
            raise ConfigError(f"{where}: stats of {name} must have {', '.join(BASICS)}")
        kept = {key: values[key] for key in (*BASICS, *QUANTILES) if values.get(key) is not None}
        stats[name] = {key: parse_numbers(value, f"{where}: stats/{name}/{key}") for key, value in kept.items()}
        stats[name]["count"] = stats[name]["count"].astype(np.int64)
    return stats


def parse_numbers(value: Any, where: str) -> Any:
    """Finite numbers, however nested. Raises ConfigError."""
    try:
        array = np.array(value, float)
    except (ValueError, TypeError, OverflowError):
        raise ConfigError(f"{where}: {value!r:.60} are no numbers") from None
    if array.size == 0 or not np.isfinite(array).all() or np.abs(array).max() > 1e300:
        raise ConfigError(f"{where}: {value!r:.60} must be finite numbers")
    return array


def count(entry: Mapping[str, Any], name: str, where: str, most: int) -> int:
    """A whole number from 0. Raises ConfigError."""
    value = entry.get(name)
    if type(value) is not int or not 0 <= value <= most:
        raise ConfigError(f"{where}: {name} must be a whole number from 0 to {most}, not {value!r:.60}")
    return value


def require_text(text: Any, where: str) -> str:
    """A task. Raises ConfigError."""
    if not isinstance(text, str) or len(text) > LONGEST_TEXT:
        raise ConfigError(f"{where}: {text!r:.60} is no text of at most {LONGEST_TEXT} characters")
    return text


def data_path(root: Path, info: Info, row: EpisodeRow) -> Path:
    """The Parquet file with an episode's rows. Raises ConfigError."""
    return inside(root, fill(info.data_path, info, row, "data"))


def video_path(root: Path, info: Info, row: EpisodeRow, camera: str) -> Path:
    """The MP4 file with an episode's frames. Raises ConfigError."""
    return inside(root, fill(info.video_path, info, row, f"videos/{camera}", camera))


def fill(template: Template, info: Info, row: EpisodeRow, name: str, camera: str = "") -> str:
    """A path of an episode, below the dataset's folder."""
    numbers = {"episode_index": row.index, "episode_chunk": row.index // info.chunks_size}
    numbers["chunk_index"] = row.places.get(f"{name}/chunk_index", 0)
    numbers["file_index"] = row.places.get(f"{name}/file_index", 0)
    return template.fill(**numbers, video_key=camera).as_posix()
