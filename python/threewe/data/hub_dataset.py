"""What the Hub needs to know about a LeRobot v3.0 dataset: its figures and its files. Nothing of it is trusted."""

from __future__ import annotations

import importlib
import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from threewe._files import read_text
from threewe.errors import ConfigError

VERSION = "v3.0"
"""The format, and the tag by which LeRobot finds it on the Hub."""
FOLDERS = ("meta", "data", "videos", "images")
"""All that belongs to a dataset; whatever else lies in its folder stays private."""
DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEO_PATH = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
MOST = 10**9
"""Frames and episodes, at most: a number from a file that is larger is none."""


@dataclass(frozen=True)
class Feature:
    """One column of a dataset."""

    name: str
    dtype: str
    shape: tuple[int, ...]
    names: tuple[str, ...]


@dataclass(frozen=True)
class Clip:
    """Where the video of an episode is."""

    path: Path
    begin: float
    """[s] in the file"""
    end: float
    """[s] in the file"""


@dataclass(frozen=True)
class HubDataset:
    """A LeRobot v3.0 dataset in a folder."""

    folder: Path
    robot: str
    fps: float
    episodes: int
    frames: int
    features: tuple[Feature, ...]
    tasks: tuple[str, ...]
    clips: tuple[Clip, ...]
    """of the first camera, one an episode"""
    files: tuple[PurePosixPath, ...]
    """all that belong to it, relative to the folder"""
    size: int
    """[bytes] of all files"""

    @classmethod
    def read(cls, folder: Path) -> HubDataset:
        """Reads the metadata, and checks that the files are there which it names.

        Raises:
            ConfigError: no dataset of this format, a file that is missing, or a symbolic link.
        """
        if not folder.is_dir():
            raise ConfigError(f"{folder}: no such folder")
        if not (folder / "meta" / "info.json").exists():
            raise ConfigError(f"{folder}: not a LeRobot dataset: meta/info.json is missing")
        info = _Info(folder / "meta" / "info.json")
        files = tuple(sorted(_files(folder)))
        rows = _episodes(folder)
        if len(rows) != info.number("total_episodes"):
            raise ConfigError(
                f"{folder}: meta/episodes has {len(rows)} episodes, meta/info.json says {info.number('total_episodes')}"
            )
        features = info.features()
        cameras = [feature.name for feature in features if feature.dtype == "video"]
        _check_references(folder, rows, cameras, set(files))
        return cls(
            folder=folder,
            robot=info.text("robot_type", "unknown"),
            fps=info.fps(),
            episodes=len(rows),
            frames=info.number("total_frames"),
            features=features,
            tasks=_tasks(folder),
            clips=tuple(_clip(folder, row, cameras[0]) for row in rows) if cameras else (),
            files=files,
            size=sum((folder / file).stat().st_size for file in files),
        )


class _Info:
    """`meta/info.json`, field by field."""

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._fields = json.loads(read_text(path))
        except (ValueError, RecursionError) as error:
            if isinstance(error, ConfigError):
                raise
            raise ConfigError(f"{path}: not JSON: {error}") from None
        if not isinstance(self._fields, dict):
            raise self._wrong("the file", "an object")
        version = self._fields.get("codebase_version")
        if version != VERSION:
            raise ConfigError(
                f"{path}: codebase_version is {version!r}, not '{VERSION}': convert it with threewe data convert"
            )
        for field, expected in (("data_path", DATA_PATH), ("video_path", VIDEO_PATH)):
            if self._fields.get(field) not in (expected, None):
                raise self._wrong(field, f"'{expected}'")

    def _wrong(self, field: str, right: str) -> ConfigError:
        return ConfigError(f"{self._path}: {field} must be {right}")

    def number(self, field: str) -> int:
        value = self._fields.get(field)
        if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= MOST:
            raise self._wrong(field, f"a whole number from 0 to {MOST}")
        return value

    def fps(self) -> float:
        value = self._fields.get("fps")
        if not isinstance(value, int | float) or isinstance(value, bool) or not 0.0 < value <= 1000.0:
            raise self._wrong("fps", "a number from 0 to 1000")
        return float(value)

    def text(self, field: str, default: str) -> str:
        value = self._fields.get(field)
        return value if isinstance(value, str) and value else default

    def features(self) -> tuple[Feature, ...]:
        given = self._fields.get("features")
        if not isinstance(given, dict) or not given:
            raise self._wrong("features", "an object with a feature at least")
        return tuple(self._feature(name, fields) for name, fields in given.items())

    def _feature(self, name: str, fields: Any) -> Feature:
        if not isinstance(fields, dict) or not isinstance(fields.get("dtype"), str):
            raise self._wrong(f"features.{name}", "an object with dtype and shape")
        shape = fields.get("shape")
        if not isinstance(shape, list) or not all(isinstance(n, int) and 0 < n <= MOST for n in shape):
            raise self._wrong(f"features.{name}.shape", "a list of positive whole numbers")
        if "/" in name or "\\" in name or name in ("", ".", ".."):  # videos lie in a folder of this name
            raise self._wrong(f"features.{name}", "named without '/'")
        names = fields.get("names")
        listed = names if isinstance(names, list) else []
        return Feature(name, fields["dtype"], tuple(shape), tuple(n for n in listed if isinstance(n, str)))


def _files(folder: Path) -> Iterator[PurePosixPath]:
    """All files of the dataset. A link could lead to what was never meant to be published."""
    for top in FOLDERS:
        start = folder / top
        if start.is_symlink():
            raise ConfigError(f"{start}: a symbolic link; put the folder itself there")
        if not start.exists():
            continue
        for where, folders, names in os.walk(start, onerror=_unreadable):
            for name in [*folders, *names]:
                if (Path(where) / name).is_symlink():
                    raise ConfigError(f"{Path(where) / name}: a symbolic link; put the file itself there")
            for name in names:
                if not (Path(where) / name).is_file():
                    raise ConfigError(f"{Path(where) / name}: not a regular file")
                yield PurePosixPath((Path(where) / name).relative_to(folder).as_posix())


def _unreadable(error: OSError) -> None:
    raise ConfigError(f"{error.filename}: cannot be read: {error.strerror}")


def read_columns(path: Path, wanted: list[str]) -> dict[str, list[Any]]:
    """Some columns of a parquet file, without those that it lacks. Raises ConfigError where it is broken."""
    parquet = importlib.import_module("pyarrow.parquet")  # which has no types
    try:
        with parquet.ParquetFile(path) as file:
            there = [name for name in wanted if name in file.schema_arrow.names]
            columns: dict[str, list[Any]] = file.read(columns=there).to_pydict()
            return columns
    except (OSError, ValueError) as error:  # ArrowInvalid is a ValueError
        raise ConfigError(f"{path}: not a whole parquet file: {str(error).splitlines()[0]}") from None


def _episodes(folder: Path) -> list[dict[str, Any]]:
    """One row an episode: where its data and videos are."""
    rows = []
    for path in sorted((folder / "meta" / "episodes").glob("*/*.parquet")):
        places = ["data/chunk_index", "data/file_index", *_video_columns(path)]
        columns = read_columns(path, places)
        if "data/chunk_index" not in columns or "data/file_index" not in columns:
            raise ConfigError(f"{path}: the columns data/chunk_index and data/file_index are missing")
        rows += [
            dict(zip(columns, values, strict=True)) | {"table": path} for values in zip(*columns.values(), strict=True)
        ]
    return rows


def _video_columns(path: Path) -> list[str]:
    parquet = importlib.import_module("pyarrow.parquet")
    try:
        names: list[str] = parquet.read_schema(path).names
    except (OSError, ValueError) as error:
        raise ConfigError(f"{path}: not a whole parquet file: {str(error).splitlines()[0]}") from None
    return [name for name in names if name.startswith("videos/")]


def _number(row: dict[str, Any], column: str) -> int:
    value = row.get(column)
    if not isinstance(value, int) or not 0 <= value < 10**6:
        raise ConfigError(f"{row['table']}: {column} must be a whole number below a million, got {value!r}")
    return value


def _video_path(row: dict[str, Any], camera: str) -> PurePosixPath:
    chunk, file = (_number(row, f"videos/{camera}/{part}_index") for part in ("chunk", "file"))
    return PurePosixPath(VIDEO_PATH.format(video_key=camera, chunk_index=chunk, file_index=file))


def _check_references(folder: Path, rows: list[dict[str, Any]], cameras: list[str], files: set[PurePosixPath]) -> None:
    for number, row in enumerate(rows):
        chunk, file = (_number(row, f"data/{part}_index") for part in ("chunk", "file"))
        named = [PurePosixPath(DATA_PATH.format(chunk_index=chunk, file_index=file))]
        for path in [*named, *(_video_path(row, camera) for camera in cameras)]:
            if path not in files:
                raise ConfigError(f"{folder / path}: missing; episode {number} is in it")


def _clip(folder: Path, row: dict[str, Any], camera: str) -> Clip:
    begin, end = (row.get(f"videos/{camera}/{part}_timestamp") for part in ("from", "to"))
    if not isinstance(begin, float) or not isinstance(end, float) or not 0.0 <= begin <= end < MOST:
        raise ConfigError(f"{row['table']}: videos/{camera}/from_timestamp and to_timestamp must be times [s] in order")
    return Clip(folder / _video_path(row, camera), begin, end)


def _tasks(folder: Path) -> tuple[str, ...]:
    path = folder / "meta" / "tasks.parquet"
    if not path.exists():
        return ()
    tasks = next(iter(read_columns(path, ["task", "__index_level_0__"]).values()), [])
    return tuple(task for task in tasks if isinstance(task, str))
