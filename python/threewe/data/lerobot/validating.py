"""Validates a LeRobot dataset: every file, row, statistic and frame."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from threewe.data.lerobot.checking import check_column_stats, check_image_stats, check_order, check_total_stats
from threewe.data.lerobot.dataset import Dataset, Episode, TableImages
from threewe.data.lerobot.info import read_json
from threewe.data.lerobot.metadata import data_path, video_path
from threewe.data.lerobot.places import inside
from threewe.data.lerobot.stats import PixelCounts, Stats
from threewe.data.lerobot.video_track import VideoTrack, open_video
from threewe.errors import ConfigError

Progress = Callable[[int, int], None]
MOST_PROBLEMS = 1000
MEANT_TO_BE_THERE = re.compile(r"(\..*|README.*|LICENSE.*)")
META_V30 = {"meta/info.json", "meta/stats.json", "meta/tasks.parquet"}
META_V21 = {"meta/info.json", "meta/tasks.jsonl", "meta/episodes.jsonl", "meta/episodes_stats.jsonl"}


@dataclass(frozen=True)
class Problem:
    """Something wrong: in which file below the dataset's folder, in which row (or line), what, and what is right."""

    file: str
    row: int | None
    what: str

    def __str__(self) -> str:
        return f"{self.file}: {'' if self.row is None else f'row {self.row}: '}{self.what}"


def validate(root: str | Path, *, on_progress: Progress | None = None) -> list[Problem]:
    """All problems of a dataset, at most a thousand; none for a sound one.

    It decodes every video. It raises nothing for what is in the dataset.
    """
    folder = Path(root)
    problems: list[Problem] = []
    try:
        dataset = Dataset.open(folder)
    except ConfigError as error:
        return [problem_of(error, folder)]
    total = len(dataset.episodes)
    for done, episode in enumerate(dataset.episodes):
        if on_progress is not None:
            on_progress(done, total)
        problems += guarded(folder, partial(check_episode, episode))
        if len(problems) >= MOST_PROBLEMS:
            return problems[:MOST_PROBLEMS]
    problems += guarded(folder, partial(check_files, dataset))
    problems += guarded(folder, partial(check_totals, dataset))
    if on_progress is not None:
        on_progress(total, total)
    return list(dict.fromkeys(problems))[:MOST_PROBLEMS]


def guarded(root: Path, check: Callable[[], Iterator[Problem]]) -> list[Problem]:
    """Problems up to one that ends the check."""
    found: list[Problem] = []
    try:
        for problem in check():
            found.append(problem)
            if len(found) >= MOST_PROBLEMS:
                break
    except ConfigError as error:
        found.append(problem_of(error, root))
    return found


def problem_of(error: ConfigError, root: Path) -> Problem:
    """An error's file and row, from its message."""
    text = str(error)
    for folder in (str(root.resolve()), str(root)):
        text = text.replace(f"{folder}{os.sep}", "")
    match = re.match(r"(?P<file>[^:]+)(?::(?P<line>\d+))?: (?:row (?P<row>\d+): )?(?P<what>.*)", text, re.DOTALL)
    if match is None:
        return Problem("", None, text)
    row = match["line"] or match["row"]
    return Problem(match["file"], None if row is None else int(row), match["what"])


def check_episode(episode: Episode) -> Iterator[Problem]:
    """Its rows, statistics and frames."""
    dataset = episode.dataset
    file = below(dataset, data_path(dataset.root, dataset.info, episode.row))
    columns = episode.columns()
    first = episode.rows.start
    for row, what in check_order(columns, episode, dataset.fps):
        yield Problem(file, first + row, what)
    tasks = set(episode.frame_tasks(columns))
    where = "meta/episodes" if dataset.version == "v3.0" else "meta/episodes.jsonl"
    if tasks != set(episode.tasks):
        yield Problem(where, episode.index, f"tasks {episode.tasks!r:.200}; its frames have {sorted(tasks)!r:.200}")
    stats = episode.stats()
    for what in check_column_stats(columns, stats, dataset.info):
        yield Problem(where, episode.index, what)
    for camera in dataset.info.cameras if dataset.version == "v3.0" else ():
        begin, end = (episode.row.places[f"videos/{camera}/{edge}_timestamp"] for edge in ("from", "to"))
        if abs((end - begin) * dataset.fps - episode.length) > 0.5:
            right = f"{episode.length} frames take {episode.length / dataset.fps:g} s"
            yield Problem(where, episode.index, f"{camera}: from {begin:g} to {end:g} s; {right}")
    for camera in episode.cameras():
        yield from guarded(dataset.root, partial(check_frames, episode, camera, stats, where))


def check_frames(episode: Episode, camera: str, stats: Mapping[str, Stats], where: str) -> Iterator[Problem]:
    """Decodes all frames of a camera; as many as there are rows, at their times, and with the statistics noted."""
    source = episode.video(camera)
    feature = episode.dataset.features[camera]
    counts = PixelCounts(len(source), feature)
    expected = 0
    for number, image in images_of(source):
        if number != expected:
            break
        counts.add(number, image)
        expected += 1
    if expected != len(source) and isinstance(source, VideoTrack):
        time = (source.start + expected) / source.fps
        what = f"no frame at {time:.4f} s, which is frame {expected} of the {len(source)} of episode {episode.index}"
        yield Problem(below(episode.dataset, source.path), None, what)
        return
    for what in check_image_stats(camera, counts.stats(), stats.get(camera), depth=feature.is_depth):
        yield Problem(where, episode.index, what)


def images_of(source: Any) -> Iterator[tuple[int, NDArray[Any]]]:
    """Numbers and pixels of all frames there are."""
    if isinstance(source, TableImages):
        yield from ((i, source.image(i)) for i in range(len(source)))
    else:
        yield from source.images()


def check_files(dataset: Dataset) -> Iterator[Problem]:
    """Files and frames that belong to no episode, and what `meta/info.json` says of videos."""
    known = set(META_V30 if dataset.version == "v3.0" else META_V21)
    frames: dict[tuple[str, Path], int] = {}
    for episode in dataset.episodes:
        known.add(below(dataset, data_path(dataset.root, dataset.info, episode.row)))
        for camera in dataset.info.cameras:
            path = video_path(dataset.root, dataset.info, episode.row, camera)
            known.add(below(dataset, path))
            begin = episode.row.places.get(f"videos/{camera}/from_timestamp", 0.0)
            end = round(begin * dataset.fps) + episode.length
            frames[camera, path] = max(frames.get((camera, path), 0), end)
    for (camera, path), wanted in frames.items():
        yield from guarded(dataset.root, partial(check_video, dataset, camera, path, wanted))
    for where, folders, names in os.walk(dataset.root):
        folders[:] = [name for name in folders if not MEANT_TO_BE_THERE.fullmatch(name)]
        for name in sorted(names):
            file = (Path(where) / name).relative_to(dataset.root).as_posix()
            if dataset.version == "v3.0" and re.fullmatch(r"meta/episodes/[^/]+/[^/]+\.parquet", file):
                continue
            if file not in known and not MEANT_TO_BE_THERE.fullmatch(name):
                yield Problem(file, None, "belongs to no episode: remove it, or the metadata is not of this dataset")


def check_video(dataset: Dataset, camera: str, path: Path, wanted: int) -> Iterator[Problem]:
    """The number of frames of a file, and its codec."""
    feature = dataset.features[camera]
    with open_video(path, feature) as container:
        stream = container.streams.video[0]
        found, pix_fmt = stream.frames, stream.codec_context.pix_fmt
        packets = sum(1 for packet in container.demux(stream) if packet.pts is not None)
    if {found, packets} - {0} != {wanted}:
        yield Problem(
            below(dataset, path), None, f"{packets} frames ({found} by its header); its episodes have {wanted}"
        )
    noted = feature.info.get("video.fps", dataset.fps)
    if noted != dataset.fps:
        yield Problem("meta/info.json", None, f"{camera}: video.fps {noted!r:.40}; the dataset has {dataset.fps}")
    if feature.is_depth and pix_fmt != "gray12le":
        yield Problem(below(dataset, path), None, f"{camera}: {pix_fmt}; depth is in 12-bit codes, gray12le")


def check_totals(dataset: Dataset) -> Iterator[Problem]:
    """Splits and counts of `meta/info.json`, and `meta/stats.json`."""
    raw = read_json(inside(dataset.root, "meta/info.json"))
    count = len(dataset)
    for name, part in (raw.get("splits") or {}).items() if isinstance(raw.get("splits"), dict) else ():
        match = re.fullmatch(r"(\d+):(\d+)", part) if isinstance(part, str) else None
        if match is None or not int(match[1]) <= int(match[2]) <= count:
            yield Problem("meta/info.json", None, f"splits: {name!r:.40} is {part!r:.40}; it must be within 0:{count}")
    videos = count * len(dataset.info.cameras)
    if dataset.version == "v2.1" and raw.get("total_videos", videos) != videos:
        yield Problem("meta/info.json", None, f"total_videos {raw['total_videos']!r:.40}; there are {videos}")
    if dataset.version == "v3.0":
        episodes = [episode.stats() for episode in dataset.episodes]
        for what in check_total_stats(dataset.stats(), episodes):
            yield Problem("meta/stats.json", None, what)


def below(dataset: Dataset, path: Path) -> str:
    """A file's name below the dataset's folder."""
    return path.relative_to(dataset.root.resolve()).as_posix()
