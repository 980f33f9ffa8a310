"""Makes datasets of datasets: merge, split, filter, convert. Videos are copied packet by packet where possible."""

from __future__ import annotations

import random
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path

from threewe.data.lerobot.cameras import Codec
from threewe.data.lerobot.dataset import Dataset, Episode, TableImages
from threewe.data.lerobot.features import DEFAULT_FEATURES
from threewe.data.lerobot.info import Version
from threewe.data.lerobot.video_track import VideoTrack
from threewe.data.lerobot.writer import DatasetWriter
from threewe.errors import ConfigError

Progress = Callable[[int, int], None]
"""Called with the episodes that are done, and all of them."""


def merge(
    sources: Sequence[str | Path], target: str | Path, *, codec: Codec = "copy", on_progress: Progress | None = None
) -> Dataset:
    """All episodes of some datasets in a new one, in the version of the first.

    Raises ConfigError where rate, robot or features differ, and where `target` exists.
    """
    if not sources:
        raise ConfigError("merge: no dataset was given")
    datasets = [Dataset.open(source) for source in sources]
    for other in datasets[1:]:
        require_alike(datasets[0], other)
    return _write(target, [episode for each in datasets for episode in each.episodes], codec, None, on_progress)


def split(
    source: str | Path,
    parts: Mapping[str | Path, float | Sequence[int]],
    *,
    seed: int | None = None,
    codec: Codec = "copy",
    on_progress: Progress | None = None,
) -> list[Dataset]:
    """Some datasets of one: `{"train": 0.8, "test": 0.2}` shares it out in order, or shuffled where a seed is given.

    Instead of its share a part can name its episodes. Raises ConfigError for shares over 1, numbers of episodes that do
    not exist, a part without an episode, and where a part exists.
    """
    dataset = Dataset.open(source)
    order = list(range(len(dataset)))
    if seed is not None:
        random.Random(seed).shuffle(order)
    chosen: dict[Path, list[int]] = {}
    begin = 0.0
    for name, part in parts.items():
        if isinstance(part, int | float):
            end = begin + part
            if not 0 < part <= 1 or end > 1 + 1e-9:
                raise ConfigError(f"split: {name}: {part:g}; shares are from 0 to 1 and add up to 1 at most")
            chosen[Path(name)] = sorted(order[round(begin * len(order)) : round(end * len(order))])
            begin = end
        else:
            chosen[Path(name)] = [require_episode(dataset, index) for index in part]
        if not chosen[Path(name)]:
            raise ConfigError(f"split: {name}: no episode is left for it; {dataset.root} has {len(dataset)}")
    made = []
    for target, indices in chosen.items():
        made.append(_write(target, [dataset.episodes[i] for i in indices], codec, None, on_progress))
    return made


def filter_episodes(
    source: str | Path,
    target: str | Path,
    *,
    episodes: Collection[int] | None = None,
    tasks: Collection[str] | None = None,
    success: bool | None = None,
    min_length: int = 1,
    max_length: int | None = None,
    keep: Callable[[Episode], bool] | None = None,
    codec: Codec = "copy",
    on_progress: Progress | None = None,
) -> Dataset:
    """A dataset of those episodes that meet all conditions: number, one of the tasks, success, frames, and `keep`.

    Raises ConfigError where none does, or the dataset does not say which succeeded.
    """
    dataset = Dataset.open(source)
    wanted = {require_episode(dataset, index) for index in range(len(dataset)) if episodes is None}
    wanted |= {require_episode(dataset, index) for index in episodes or ()}
    if unknown := sorted(set(tasks or ()) - set(dataset.tasks)):
        raise ConfigError(
            f"{dataset.root}: no task {unknown[0]!r}; there are {', '.join(map(repr, dataset.tasks))!s:.500}"
        )

    def meets(episode: Episode) -> bool:
        if episode.index not in wanted or not min_length <= episode.length <= (max_length or episode.length):
            return False
        if tasks is not None and not set(tasks) & set(episode.tasks):
            return False
        if success is not None:
            succeeded = episode.success()
            if succeeded is None:
                raise ConfigError(f"{dataset.root}: no column next.success or success says which episodes succeeded")
            if succeeded != success:
                return False
        return keep is None or keep(episode)

    kept = [episode for episode in dataset.episodes if meets(episode)]
    if not kept:
        raise ConfigError(f"{dataset.root}: no episode of {len(dataset)} meets these conditions")
    return _write(target, kept, codec, None, on_progress)


def convert(
    source: str | Path,
    target: str | Path,
    *,
    version: Version,
    codec: Codec = "copy",
    on_progress: Progress | None = None,
) -> Dataset:
    """The same dataset in another version of the format, or with videos of another codec. Raises ConfigError."""
    return _write(target, list(Dataset.open(source).episodes), codec, version, on_progress)


def append(
    root: str | Path,
    sources: Sequence[str | Path],
    *,
    codec: Codec | None = "copy",
    on_progress: Progress | None = None,
) -> Dataset:
    """Adds the episodes of datasets to one that exists; until all are there it stays as it was. Raises ConfigError."""
    there = Dataset.open(root)
    others = [Dataset.open(source) for source in sources]
    for other in others:
        require_alike(there, other)
    with DatasetWriter.append(root, codec=codec) as writer:
        copy_episodes(writer, [episode for each in others for episode in each.episodes], on_progress)
    return Dataset.open(root)


def require_alike(first: Dataset, other: Dataset) -> None:
    """Raises ConfigError where two datasets cannot be one."""
    for what in ("fps", "robot_type"):
        ours, theirs = getattr(first.info, what), getattr(other.info, what)
        if ours != theirs:
            raise ConfigError(f"{other.root}: {what} {theirs!r}; {first.root} has {ours!r}")
    if different := sorted(first.features.keys() ^ other.features.keys()):
        raise ConfigError(f"{other.root} and {first.root}: only one has {', '.join(different)}")
    for name, ours in first.features.items():
        theirs = other.features[name]
        for what in ("dtype", "shape", "names", "is_depth"):
            if getattr(ours, what) != getattr(theirs, what):
                found, wanted = getattr(theirs, what), getattr(ours, what)
                raise ConfigError(f"{other.root}: {name} has {what} {found!r:.80}; {first.root} has {wanted!r:.80}")
        if ours.mount and theirs.mount and ours.mount != theirs.mount:
            raise ConfigError(f"{other.root}: the sensor of {name} is mounted elsewhere than that of {first.root}")


def require_episode(dataset: Dataset, index: int) -> int:
    """Raises ConfigError where there is no such episode."""
    if not 0 <= index < len(dataset):
        raise ConfigError(f"{dataset.root}: no episode {index}; there are 0 to {len(dataset) - 1}")
    return index


def copy_episodes(writer: DatasetWriter, episodes: Sequence[Episode], on_progress: Progress | None = None) -> None:
    """Adds episodes of other datasets to a writer."""
    for done, episode in enumerate(episodes):
        if on_progress is not None:
            on_progress(done, len(episodes))
        columns = episode.columns()
        stats = episode.stats()
        videos = {name: episode.video(name) for name in episode.cameras()}
        for name, source in videos.items():
            if isinstance(source, VideoTrack | TableImages):
                source.stats = stats.get(name)
        own = {name: values for name, values in columns.items() if name not in DEFAULT_FEATURES}
        writer.add_episode(own, episode.frame_tasks(columns), videos)
    if on_progress is not None:
        on_progress(len(episodes), len(episodes))


def _write(
    target: str | Path,
    episodes: Sequence[Episode],
    codec: Codec,
    version: Version | None,
    on_progress: Progress | None,
) -> Dataset:
    """A new dataset of episodes, whose features, rate, robot and limits of files are those of the first."""
    first = episodes[0].dataset
    with DatasetWriter(
        target,
        fps=first.fps,
        features=first.own_features,
        robot_type=first.info.robot_type,
        version=version or first.version,
        codec=codec,
        chunks_size=first.info.chunks_size,
        data_files_size_in_mb=first.info.data_files_size_in_mb,
        video_files_size_in_mb=first.info.video_files_size_in_mb,
    ) as writer:
        copy_episodes(writer, episodes, on_progress)
    return Dataset.open(target)
