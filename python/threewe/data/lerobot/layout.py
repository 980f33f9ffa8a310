"""Where the parts of an episode go in each version of the format: many episodes a file in v3.0, one in v2.1."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from threewe.data.lerobot.clips import Clip, StreamParameters
from threewe.data.lerobot.info import Info
from threewe.data.lerobot.places import EPISODES_V30, Template, next_file
from threewe.data.lerobot.stats import QUANTILES, Stats, aggregate
from threewe.data.lerobot.tables import episode_table, frame_table, plain_stats, write_tasks
from threewe.data.lerobot.video_file import MIB, VideoFile, VideoFiles

if TYPE_CHECKING:
    import pyarrow.parquet as pq


@dataclass
class EpisodeRow:
    """What the metadata says of one episode; `start` is the dataset's number of its first frame."""

    index: int
    tasks: list[str]
    length: int
    start: int
    stats: Mapping[str, Stats]
    places: dict[str, Any] = field(default_factory=dict)


@dataclass
class Before:
    """The episodes of a dataset that is continued, and the statistics of all of them together (v3.0)."""

    rows: list[EpisodeRow]
    stats: Mapping[str, Stats]
    state: tuple[int, ...] = ()


class Layout(ABC):
    """Puts episodes into files, below a folder."""

    def __init__(self, root: Path, info: Info) -> None:
        self.root, self.info = root, info
        self.parameters: dict[str, StreamParameters] = {}
        self.before = Before([], {})

    def resume(self, before: Before) -> None:
        """Continues behind the files that are there."""
        self.before = before

    @abstractmethod
    def add(self, row: EpisodeRow, columns: Mapping[str, Any], clips: Mapping[str, Clip]) -> None:
        """Writes an episode and notes in its row where."""

    @abstractmethod
    def close(self, info: Info, tasks: Sequence[str], rows: Sequence[EpisodeRow]) -> None:
        """Completes the files; `meta/info.json` comes last."""

    @abstractmethod
    def abandon(self) -> None:
        """Closes what is open."""

    def path(self, template: Template, **values: int | str) -> Path:
        """A file's path, in a folder that is there."""
        path = self.root / template.fill(**values)
        path.parent.mkdir(parents=True, exist_ok=True)
        return path


def layout_of(root: Path, info: Info) -> Layout:
    """That of a version."""
    return LayoutV30(root, info) if info.version == "v3.0" else LayoutV21(root, info)


class LayoutV30(Layout):
    """Episodes follow one another in Parquet and MP4 files, up to limits of 100 and 200 MiB."""

    def __init__(self, root: Path, info: Info) -> None:
        super().__init__(root, info)
        self.data = self.first = (0, 0)
        self.table: pq.ParquetWriter | None = None
        self.frames_in_file = 0
        limit = info.video_files_size_in_mb
        self.videos = {name: VideoFiles(info.fps, limit) for name in info.cameras}
        self.video_places: dict[str, tuple[int, int] | None] = dict.fromkeys(info.cameras)

    def resume(self, before: Before) -> None:
        """With new files; those that are there stay as they are."""
        super().resume(before)

        def place(name: str) -> tuple[int, int]:
            return max((row.places[f"{name}/chunk_index"], row.places[f"{name}/file_index"]) for row in before.rows)

        self.data = next_file(*place("data"), self.info.chunks_size)
        self.video_places = {name: place(f"videos/{name}") for name in self.info.cameras}

    def add(self, row: EpisodeRow, columns: Mapping[str, Any], clips: Mapping[str, Clip]) -> None:
        """An episode is a row group of the table and a stretch of each video."""
        self._add_frames(row, columns)
        row.places |= {"data/chunk_index": self.data[0], "data/file_index": self.data[1]}
        row.places |= {"dataset_from_index": row.start, "dataset_to_index": row.start + row.length}
        for name, clip in clips.items():
            self._add_clip(row, name, clip)

    def close(self, info: Info, tasks: Sequence[str], rows: Sequence[EpisodeRow]) -> None:
        """Tasks, episodes, statistics, info."""
        self.abandon()
        write_tasks(self.root / "meta/tasks.parquet", tasks)
        self._write_episodes(rows)
        write_json(self.root / "meta/stats.json", plain_stats(total_stats(rows, self.before.stats)))
        write_json(self.root / "meta/info.json", info.to_json())

    def abandon(self) -> None:
        """Closes tables and videos."""
        if self.table is not None:
            self.table.close()
            self.table = None
        for videos in self.videos.values():
            videos.close()

    def _add_frames(self, row: EpisodeRow, columns: Mapping[str, Any]) -> None:
        import pyarrow.parquet as pq

        table = frame_table(columns, self.info.columns)
        path = self.path(self.info.data_path, chunk_index=self.data[0], file_index=self.data[1])
        if self.table is not None:
            size = path.stat().st_size / MIB
            if size + size / self.frames_in_file * row.length >= self.info.data_files_size_in_mb:
                self.table.close()
                self.table = None
                self.data = next_file(*self.data, self.info.chunks_size)
                path = self.path(self.info.data_path, chunk_index=self.data[0], file_index=self.data[1])
        if self.table is None:
            self.table = pq.ParquetWriter(path, table.schema, compression="snappy", use_dictionary=True)
            self.frames_in_file = 0
        self.table.write_table(table)
        self.frames_in_file += row.length

    def _add_clip(self, row: EpisodeRow, name: str, clip: Clip) -> None:
        def begin() -> Path:
            last = self.video_places[name]
            place = self.first if last is None else next_file(*last, self.info.chunks_size)
            self.video_places[name] = place
            return self.path(self.info.video_path, video_key=name, chunk_index=place[0], file_index=place[1])

        _, start, end = self.videos[name].add(clip, begin)
        self.parameters.setdefault(name, clip.parameters)
        chunk, file = self.video_places[name] or self.first
        row.places |= {
            f"videos/{name}/chunk_index": chunk,
            f"videos/{name}/file_index": file,
            f"videos/{name}/from_timestamp": start / self.info.fps,
            f"videos/{name}/to_timestamp": end / self.info.fps,
        }

    def _write_episodes(self, rows: Sequence[EpisodeRow]) -> None:
        """Ten episodes a row group, as LeRobot flushes them, up to the limit of a file."""
        import pyarrow.parquet as pq

        place = self._first_episodes()
        writer: pq.ParquetWriter | None = None
        template = Template(EPISODES_V30, "meta/episodes")
        for begin in range(0, len(rows), 10):
            path = self.path(template, chunk_index=place[0], file_index=place[1])
            if writer is not None and path.stat().st_size >= self.info.data_files_size_in_mb * MIB:
                writer.close()
                place, writer = next_file(*place, self.info.chunks_size), None
                path = self.path(template, chunk_index=place[0], file_index=place[1])
            table = episode_table([episode_entry(row, place) for row in rows[begin : begin + 10]])
            writer = writer or pq.ParquetWriter(path, table.schema, compression="snappy", use_dictionary=True)
            writer.write_table(table)
        if writer is not None:
            writer.close()

    def _first_episodes(self) -> tuple[int, int]:
        """The first file of episodes that is not there yet."""
        place, template = (0, 0), Template(EPISODES_V30, "meta/episodes")
        while (self.root / template.fill(chunk_index=place[0], file_index=place[1])).exists():
            place = next_file(*place, self.info.chunks_size)
        return place


class LayoutV21(Layout):
    """A Parquet file and an MP4 file a camera for each episode; metadata in JSON lines."""

    def add(self, row: EpisodeRow, columns: Mapping[str, Any], clips: Mapping[str, Clip]) -> None:
        """Writes the episode's own files."""
        import pyarrow.parquet as pq

        numbers = {"episode_chunk": row.index // self.info.chunks_size, "episode_index": row.index}
        pq.write_table(frame_table(columns, self.info.columns), self.path(self.info.data_path, **numbers))
        for name, clip in clips.items():
            path = self.path(self.info.video_path, video_key=name, **numbers)
            VideoFile(path, self.info.fps, clip).close()
            self.parameters.setdefault(name, clip.parameters)

    def close(self, info: Info, tasks: Sequence[str], rows: Sequence[EpisodeRow]) -> None:
        """Tasks, episodes, statistics (that version has no quantiles), info."""
        meta = self.root / "meta"
        write_json_lines(meta / "tasks.jsonl", [{"task_index": i, "task": task} for i, task in enumerate(tasks)])
        entries = [{"episode_index": row.index, "tasks": row.tasks, "length": row.length} for row in rows]
        add_json_lines(meta / "episodes.jsonl", entries)
        add_json_lines(meta / "episodes_stats.jsonl", [stats_entry(row) for row in rows])
        write_json(meta / "info.json", info.to_json())

    def abandon(self) -> None:
        """Nothing is open."""


def total_stats(rows: Sequence[EpisodeRow], before: Mapping[str, Stats]) -> dict[str, Stats]:
    """Statistics of all episodes, those that were there before among them."""
    known = {name: [before[name]] if name in before else [] for name in rows[0].stats}
    return {name: aggregate([*known[name], *(row.stats[name] for row in rows)]) for name in known}


def episode_entry(row: EpisodeRow, place: tuple[int, int]) -> dict[str, Any]:
    """A row of `meta/episodes`."""
    stats = {f"stats/{name}/{key}": value for name, each in row.stats.items() for key, value in each.items()}
    head = {"episode_index": row.index, "tasks": row.tasks, "length": row.length}
    return {**head, **row.places, **stats, "meta/episodes/chunk_index": place[0], "meta/episodes/file_index": place[1]}


def stats_entry(row: EpisodeRow) -> dict[str, Any]:
    """A line of `episodes_stats.jsonl`."""
    kept = {name: {key: each[key] for key in each if key not in QUANTILES} for name, each in row.stats.items()}
    return {"episode_index": row.index, "stats": plain_stats(kept)}


def write_json(path: Path, value: Any) -> None:
    """Indented as LeRobot does."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(value, indent=4, ensure_ascii=False), "utf-8")


def add_json_lines(path: Path, values: Sequence[Any]) -> None:
    """A value a line, behind those that are there."""
    there = path.read_bytes() if path.exists() else b""
    with path.open("wb") as file:
        file.write(there if not there or there.endswith(b"\n") else there + b"\n")
        file.write("".join(json.dumps(value, ensure_ascii=False) + "\n" for value in values).encode())


def write_json_lines(path: Path, values: Sequence[Any]) -> None:
    """A value a line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(json.dumps(value, ensure_ascii=False) + "\n" for value in values), "utf-8")
