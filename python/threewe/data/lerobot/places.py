"""Where the files of a dataset are: its path templates, and paths that never leave its folder."""

from __future__ import annotations

import stat
from pathlib import Path, PurePosixPath
from string import Formatter
from typing import Any

from threewe.errors import ConfigError

FIELDS = {"chunk_index", "file_index", "episode_chunk", "episode_index", "video_key"}
SPECS = {"", "d", "03d", "06d", "02d", "04d", "05d", "08d"}

DATA_V30 = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEO_V30 = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
EPISODES_V30 = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
DATA_V21 = "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet"
VIDEO_V21 = "videos/chunk-{episode_chunk:03d}/{video_key}/episode_{episode_index:06d}.mp4"


class Template:
    """A path with numbers and names to fill in, such as `data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet`.

    It is read as data: plain field names and widths are all that it may contain. Raises ConfigError for anything else.
    """

    def __init__(self, text: Any, where: str) -> None:
        if not isinstance(text, str) or not 0 < len(text) <= 500:
            raise ConfigError(f"{where}: must be a path such as {DATA_V30!r}, not {text!r:.60}")
        try:
            self.parts = list(Formatter().parse(text))
        except ValueError as error:
            raise ConfigError(f"{where}: {text!r:.120}: {error}") from None
        for literal, name, spec, conversion in self.parts:
            if name is not None and (name not in FIELDS or (spec or "") not in SPECS or conversion is not None):
                known = ", ".join(sorted(FIELDS))
                raise ConfigError(f"{where}: {text!r:.120}: {{{name}:{spec}}} is no field of a path; known are {known}")
            if not literal.isprintable() or "\\" in literal:
                raise ConfigError(f"{where}: {text!r:.120}: characters that no path has")
        self.text, self.where = text, where
        self.fill(**dict.fromkeys(FIELDS - {"video_key"}, 0), video_key="x")

    def fill(self, **values: int | str) -> PurePosixPath:
        """The path for these values, below the dataset's folder. Raises ConfigError where it would leave it."""
        words = []
        for literal, name, spec, _ in self.parts:
            words.append(literal)
            if name is not None:
                words.append(str(values[name]) if name == "video_key" else format(values[name], spec or ""))
        path = PurePosixPath("".join(words))
        if path.is_absolute() or ".." in path.parts or not path.parts:
            raise ConfigError(
                f"{self.where}: {self.text!r:.120} leads out of the dataset; it must stay below its folder"
            )
        return path


def inside(root: Path, relative: str | PurePosixPath) -> Path:
    """A regular file of the dataset. Raises ConfigError where it is none, or a link that leads out of the folder."""
    path = root / relative
    try:
        real = path.resolve(strict=True)
        mode = real.stat().st_mode
    except (OSError, RuntimeError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ConfigError(f"{path}: cannot be read: {reason}") from None
    if not real.is_relative_to(root.resolve()):
        raise ConfigError(f"{path}: a link that leads out of the dataset, to {real}; put the file itself there")
    if not stat.S_ISREG(mode):
        raise ConfigError(f"{path}: not a regular file")
    return real


def next_file(chunk: int, file: int, chunks_size: int) -> tuple[int, int]:
    """Chunk and number of the file after one."""
    return (chunk + 1, 0) if file >= chunks_size - 1 else (chunk, file + 1)
