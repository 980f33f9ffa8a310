"""Reads LeRobot datasets, v3.0 and v2.1, without LeRobot and without trusting them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from threewe.data.lerobot.columns import require_type, to_numpy
from threewe.data.lerobot.features import DEFAULT_FEATURES, Feature
from threewe.data.lerobot.frames import FrameSource, decode_image
from threewe.data.lerobot.info import Info, Version, read_info
from threewe.data.lerobot.layout import EpisodeRow
from threewe.data.lerobot.metadata import (
    data_path,
    episode_tables,
    parse_stats,
    read_episodes,
    read_stats,
    read_stats_v21,
    read_tasks,
    read_total_stats,
    video_path,
)
from threewe.data.lerobot.parquet_file import ParquetTable
from threewe.data.lerobot.stats import Stats
from threewe.data.lerobot.video_track import VideoTrack
from threewe.errors import ConfigError, ContractError

SUCCESS = ("next.success", "success")


class Dataset:
    """A dataset in a folder, of which nothing but the metadata is read until an episode is asked for.

    ```python
    dataset = Dataset.open("my_dataset")
    for episode in dataset.episodes:
        columns = episode.columns()                       # {"action": (frames, 2) float32, ...}
        frames = episode.video("observation.images.front")
        frames.image(0)                                   # (480, 640, 3) uint8 RGB
    ```

    Whatever is wrong in its files is a ConfigError with file, row and what would be right.
    """

    def __init__(self, root: Path, info: Info, tasks: Sequence[str], rows: Sequence[EpisodeRow]) -> None:
        self.root, self.info = root, info
        self.tasks: tuple[str, ...] = tuple(tasks)
        """Texts, by their number."""
        self.episodes: Sequence[Episode] = Episodes(self, rows)
        """In order; made when they are asked for."""
        self._table: ParquetTable | None = None

    @classmethod
    def open(cls, root: str | Path) -> Dataset:
        """Reads the metadata. Raises ConfigError."""
        path = Path(root)
        if not (path / "meta").is_dir():
            raise ConfigError(f"{path}: no LeRobot dataset: it has no folder meta")
        info = read_info(path)
        if not info.total_episodes:
            raise ConfigError(f"{path}: a dataset without an episode")
        return cls(path, info, read_tasks(path, info), read_episodes(path, info))

    @property
    def version(self) -> Version:
        """Of the format: "v3.0" or "v2.1"."""
        return self.info.version

    @property
    def fps(self) -> int:
        """Frames a second."""
        return self.info.fps

    @property
    def features(self) -> Mapping[str, Feature]:
        """All of them, with the five that number the frames."""
        return self.info.features

    @property
    def own_features(self) -> dict[str, Feature]:
        """Those that a writer is given: without the five that number the frames."""
        return {name: feature for name, feature in self.info.features.items() if name not in DEFAULT_FEATURES}

    def stats(self) -> dict[str, Stats]:
        """Statistics of all episodes: `meta/stats.json` (v3.0). Raises ConfigError."""
        return read_total_stats(self.root, self.info)

    @cached_property
    def episode_tables(self) -> list[ParquetTable]:
        """The files of `meta/episodes` (v3.0). Raises ConfigError."""
        return episode_tables(self.root)

    @cached_property
    def older_stats(self) -> dict[Any, Any]:
        """Statistics of all episodes in v2.1, by number, unchecked. Raises ConfigError."""
        return read_stats_v21(self.root)

    def __len__(self) -> int:
        return self.info.total_episodes

    def __repr__(self) -> str:
        counts = f"{self.info.total_episodes} episodes, {self.info.total_frames} frames at {self.fps} Hz"
        return f"Dataset({str(self.root)!r}, {self.version}, {counts})"

    def table(self, path: Path) -> ParquetTable:
        """A Parquet file of frames; the last one stays open."""
        if self._table is None or self._table.path != path:
            self._table = ParquetTable(path)
            self._table.require(list(self.info.columns))
            for name, feature in self.info.columns.items():
                require_type(self._table.schema, name, feature, path)
        return self._table


class Episodes(Sequence["Episode"]):
    """The episodes of a dataset."""

    def __init__(self, dataset: Dataset, rows: Sequence[EpisodeRow]) -> None:
        self.dataset, self.rows = dataset, rows

    def __len__(self) -> int:
        return len(self.rows)

    @overload
    def __getitem__(self, index: int) -> Episode: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Episode]: ...
    def __getitem__(self, index: int | slice) -> Episode | Sequence[Episode]:
        if isinstance(index, slice):
            return Episodes(self.dataset, self.rows[index])
        return Episode(self.dataset, self.rows[index])


class Episode:
    """One episode of a dataset."""

    def __init__(self, dataset: Dataset, row: EpisodeRow) -> None:
        self.dataset, self.row = dataset, row

    @property
    def index(self) -> int:
        """Its number."""
        return self.row.index

    @property
    def length(self) -> int:
        """Frames."""
        return self.row.length

    @property
    def tasks(self) -> list[str]:
        """The texts of its tasks."""
        return self.row.tasks

    def __len__(self) -> int:
        return self.row.length

    @cached_property
    def rows(self) -> range:
        """Where its frames are in the Parquet file. Raises ConfigError."""
        path = data_path(self.dataset.root, self.dataset.info, self.row)
        numbers = self.dataset.table(path).numbers("episode_index")
        found = np.flatnonzero(numbers == self.index)
        if len(found) != self.length:
            raise ConfigError(f"{path}: {len(found)} rows of episode {self.index}; the metadata says {self.length}")
        if found[-1] - found[0] != self.length - 1:
            raise ConfigError(f"{path}: row {found[0]}: the rows of episode {self.index} do not follow one another")
        return range(int(found[0]), int(found[-1]) + 1)

    def columns(self) -> dict[str, NDArray[Any]]:
        """Each column of numbers and texts: `(frames,)` for shape (1,), else `(frames, *shape)`. Raises ConfigError."""
        info = self.dataset.info
        names = [name for name, feature in info.columns.items() if not feature.is_camera]
        file = self.dataset.table(data_path(self.dataset.root, info, self.row))
        table = file.read(names, self.rows.start, self.rows.stop)
        if table.num_rows != self.length:
            raise ConfigError(f"{file.path}: {table.num_rows} rows of episode {self.index}, which has {self.length}")
        first, path = self.rows.start, str(file.path)
        return {name: to_numpy(table, name, info.features[name], path, first) for name in names}

    def frame_tasks(self, columns: Mapping[str, NDArray[Any]]) -> list[str]:
        """The task of each frame, given its columns. Raises ConfigError."""
        tasks, path = self.dataset.tasks, data_path(self.dataset.root, self.dataset.info, self.row)
        wrong = np.flatnonzero((columns["task_index"] < 0) | (columns["task_index"] >= len(tasks)))
        if len(wrong):
            number = columns["task_index"][wrong[0]]
            place = f"{path}: row {self.rows.start + int(wrong[0])}"
            raise ConfigError(f"{place}: task_index {number}; there are {len(tasks)} tasks")
        return [tasks[number] for number in columns["task_index"]]

    def video(self, camera: str) -> FrameSource:
        """A camera's frames, whether they are in a video or in the table. Raises ConfigError."""
        info = self.dataset.info
        feature = info.features.get(camera)
        if feature is None or not feature.is_camera:
            cameras = [name for name, each in info.features.items() if each.is_camera]
            raise ContractError(f"{camera!r} is no camera; there are {', '.join(cameras) or 'none'}")
        if feature.dtype == "image":
            return TableImages(self, camera, feature)
        begin = self.row.places.get(f"videos/{camera}/from_timestamp", 0.0)
        path = video_path(self.dataset.root, info, self.row, camera)
        return VideoTrack(path, info.fps, feature, round(begin * info.fps), self.length)

    def cameras(self) -> list[str]:
        """The names of all of them."""
        return [name for name, feature in self.dataset.info.features.items() if feature.is_camera]

    def stats(self) -> dict[str, Stats]:
        """Its statistics; empty where the dataset has none. Raises ConfigError."""
        dataset = self.dataset
        if dataset.version == "v3.0":
            return read_stats(dataset.episode_tables, dataset.info, self.index)
        if not dataset.older_stats:
            return {}
        where = f"{dataset.root / 'meta/episodes_stats.jsonl'}: episode {self.index}"
        return parse_stats(dataset.older_stats.get(self.index), dataset.info, where)

    def success(self, columns: Mapping[str, NDArray[Any]] | None = None) -> bool | None:
        """Whether it succeeded: `next.success` or `success` of its last frame; None where there is no such column."""
        name = next((name for name in SUCCESS if name in self.dataset.info.columns), None)
        if name is None:
            return None
        return bool(np.ravel((columns or self.columns())[name][-1])[0])


class TableImages:
    """A FrameSource over images in the table itself; read in order, each is read once."""

    def __init__(self, episode: Episode, camera: str, feature: Feature) -> None:
        self.episode, self.camera, self.feature = episode, camera, feature
        info = episode.dataset.info
        self.file = episode.dataset.table(data_path(episode.dataset.root, info, episode.row))
        self.stats: Stats | None = None
        self._reading: Iterator[tuple[int, bytes]] = iter(())
        self._next = -1

    @property
    def shape(self) -> tuple[int, int, int]:
        """(height, width, channels)."""
        height, width, channels = self.feature.shape
        return height, width, channels

    def __len__(self) -> int:
        return self.episode.length

    def packet(self, i: int) -> None:
        """None."""

    def file_of(self, i: int) -> bytes:
        """Frame i as the PNG or TIFF file that it is. Raises ConfigError."""
        if i < self._next or self._next < 0:
            self._reading = self._files(i)
        for number, content in self._reading:
            self._next = number + 1
            if number == i:
                return content
        raise ConfigError(f"{self.file.path}: row {self.episode.rows.start + i}: {self.camera} has no image")

    def image(self, i: int) -> NDArray[Any]:
        """Frame i. Raises ConfigError."""
        where = f"{self.file.path}: row {self.episode.rows.start + i}: {self.camera}"
        return decode_image(self.file_of(i), self.feature.shape, where)

    def _files(self, first: int) -> Iterator[tuple[int, bytes]]:
        number, rows = first, self.episode.rows
        for piece in self.file.pieces([self.camera], rows.start + first, rows.stop):
            for entry in piece.column(0):
                content = entry.as_py() and entry.as_py()["bytes"]
                if not isinstance(content, bytes):
                    where = f"{self.file.path}: row {rows.start + number}"
                    raise ConfigError(f"{where}: {self.camera} has no image in the table")
                yield number, content
                number += 1
