"""What goes to the Hub of a LeRobot v3.0 dataset, and comes back: the files that belong to it, and no others."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from threewe.data.lerobot.dataset import Dataset
from threewe.data.lerobot.info import read_info
from threewe.data.lerobot.metadata import fill
from threewe.errors import ConfigError

VERSION = "v3.0"
"""The format, and the tag by which LeRobot finds it on the Hub."""
FOLDERS = ("meta", "data", "videos", "images")
"""All that belongs to a dataset; whatever else lies in its folder stays private."""


def open_whole(folder: Path) -> Dataset:
    """Opens a dataset, and checks that all files are there which its episodes are in, and that none is a link.

    Raises:
        ConfigError: no dataset of this format, a file that is missing, or a symbolic link.
    """
    info = read_info(folder)
    if info.version != VERSION:
        raise ConfigError(f"{folder}: of version {info.version}, not {VERSION}: convert it with threewe data convert")
    dataset, there = Dataset.open(folder), set(_files(folder))
    for episode in dataset.episodes:
        named = [fill(info.data_path, info, episode.row, "data")]
        named += [fill(info.video_path, info, episode.row, f"videos/{name}", name) for name in info.cameras]
        for path in named:
            if PurePosixPath(path) not in there:
                raise ConfigError(f"{folder / path}: missing; episode {episode.index} is in it")
    return dataset


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
