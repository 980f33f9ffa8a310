"""Exports of recordings: rows at a rate, as LeRobot and others want them, of ticks and samples as they came."""

from __future__ import annotations

import importlib
import logging
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from threewe._core import unknown_name
from threewe.data.recording import CONTROL_RATE, RecordedEpisode, Recording
from threewe.errors import ConfigError, ContractError

logger = logging.getLogger("threewe")

OnProgress = Callable[[int, int], object]
"""Called with the number of episodes written, and of all."""

WRITERS = {
    "lerobot": "threewe.data.export_lerobot",
    "hdf5": "threewe.data.export_hdf5",
    "mcap": "threewe.data.export_mcap",
    "rerun": "threewe.data.export_rerun",
    "tum": "threewe.data.export_tum",
}
"""Formats, and the module of each that has `OPTIONS` and `write`."""

FORMATS = tuple(WRITERS)


def export(
    recording: Recording,
    output: str | os.PathLike[str],
    format: str = "lerobot",
    *,
    fps: float | None = None,
    on_progress: OnProgress | None = None,
    **options: str | bool,
) -> Path:
    """Writes a recording for others to read.

    LeRobot datasets have rows at `fps`; what they hold is the last that was at hand at or before each. `action` is what
    the safety gate let through from a row to the next (its mean, where several ticks lie between), `action.requested`
    what was asked for in the same time. All other formats keep every tick and every sample with its own stamps.

    Args:
        recording: what is exported. Episodes without ticks are left out, with a warning.
        output: what is not there yet: of `lerobot` a folder, of `hdf5` a file, of the others a folder with a file an
            episode, or the file of a single episode where the name ends as the format's files do (.mcap, .rrd, .tum).
        format: `lerobot`, `hdf5`, `mcap` (Foxglove's schemas), `rerun` (.rrd) or `tum` (trajectories).
        fps: [Hz] of LeRobot's rows; the control rate, 50, where left out. Steps of `record_step` are rows themselves.
        on_progress: called with the numbers of episodes written and of all.
        options: of `lerobot`: `version` (`v3.0` or `v2.1`) and `codec` (`copy`, `h264` or `av1`); of `hdf5`, `mcap` and
            `rerun`: `hardware`, a robot profile that says where its sensors are, in place of the recorded one; of
            `tum`: `truth`, which adds the true trajectory of simulated robots.

    Raises:
        ConfigError: an unknown format or option, a package that is missing, no episode that has ticks, episodes that do
            not fit into one dataset, an output that exists or cannot be written. Nothing is left of it then.
        ContractError: a rate that is none.
    """
    if fps is not None and not 0 < fps <= CONTROL_RATE:
        raise ContractError(f"fps must lie in (0, {CONTROL_RATE:g}] Hz, got {fps!r}")
    if format not in WRITERS:
        raise ConfigError(unknown_name("format", format, FORMATS))
    if fps is not None and format != "lerobot":
        raise ConfigError(f"format '{format}' keeps every sample as it came: fps is for 'lerobot'")
    writer: Writer = importlib.import_module(WRITERS[format])
    for name in options:
        if name not in writer.OPTIONS:
            raise ConfigError(f"format '{format}': {unknown_name('option', name, writer.OPTIONS)}")
    episodes = TickedEpisodes(recording)
    return writer.write(episodes, Path(output), CONTROL_RATE if fps is None else fps, on_progress, **options)


class Writer(Protocol):
    """The module of a format."""

    OPTIONS: tuple[str, ...]

    def write(
        self,
        episodes: TickedEpisodes,
        output: Path,
        fps: float,
        on_progress: OnProgress | None,
        /,
        **options: str | bool,
    ) -> Path:
        """Writes all episodes. See `export`."""


class TickedEpisodes:
    """The episodes of a recording that have ticks, by their numbers; of the others one warning each says that they are
    left out."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._empty: set[int] = set()

    def __len__(self) -> int:
        """Those that are not known to be empty yet."""
        return len(self._recording) - len(self._empty)

    def __iter__(self) -> Iterator[RecordedEpisode]:
        for place in range(len(self._recording)):
            if place not in self._empty:
                episode = self._recording[place]
                if has_ticks(episode):
                    yield episode
                else:
                    self._empty.add(place)
        if len(self) == 0:
            raise ConfigError(f"{self._recording.path}: no episode has any ticks")


def has_ticks(episode: RecordedEpisode) -> bool:
    """Whether there is anything of it; warns that it is left out where not."""
    if len(episode.time):
        return True
    logger.warning("%s: %s has no ticks: it is left out", episode.file, episode_name(episode))
    return False


@contextmanager
def appearing(output: Path) -> Iterator[Path]:
    """A path to write a file or a folder to, which becomes `output` when all is written and vanishes on an error.

    Raises:
        ConfigError: it exists, or cannot be written.
    """
    if os.path.lexists(output):
        raise ConfigError(f"{output}: exists already; name another, or remove it")
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f".{output.name[:40]}.", dir=output.parent))
    except (OSError, ValueError) as error:
        raise ConfigError(f"{output}: cannot be written: {error}") from None
    try:
        yield folder / output.name
        (folder / output.name).rename(output)
    except OSError as error:
        raise ConfigError(f"{output}: cannot be written: {error}") from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def write_episodes(
    episodes: TickedEpisodes,
    output: Path,
    suffix: str,
    on_progress: OnProgress | None,
    write: Callable[[RecordedEpisode, Path], None],
) -> Path:
    """Writes a file an episode into a folder; or one file, where `output` ends in the suffix."""
    single = output.suffix == suffix
    if single and len(episodes) > 1 and (count := sum(1 for _ in episodes)) > 1:
        raise ConfigError(f"{output}: there are {count} episodes, each of which gets a file: name a folder")
    with appearing(output) as place:
        if not single:
            place.mkdir()
        for done, episode in enumerate(episodes, 1):
            write(episode, place if single else place / f"{episode_name(episode)}{suffix}")
            if on_progress is not None:
                on_progress(done, len(episodes))
    return output


def episode_name(episode: RecordedEpisode) -> str:
    """Such as episode_000003; with its robot, where that is not the first."""
    return f"episode_{episode.index:06d}" + (f"_robot_{episode.robot}" if episode.robot else "")


@dataclass(frozen=True)
class Rows:
    """When the rows of an episode are, and which ticks they show."""

    time: NDArray[np.float64]  # (N,) [s] robot time
    ticks: NDArray[np.int64]  # (N,) the last at or before
    episode: RecordedEpisode

    @classmethod
    def of(cls, episode: RecordedEpisode, fps: float) -> Rows:
        """At a rate, or where `record_step` was called."""
        time = episode.time
        steps, _ = episode.steps
        if len(steps):
            at = np.maximum(steps, time[0])
        elif fps == CONTROL_RATE:
            at = time
        else:
            at = time[0] + np.arange(int((time[-1] - time[0]) * fps + 1e-6) + 1) / fps
        return cls(at, last_before(time, at), episode)

    def following(self, values: NDArray[np.float64]) -> NDArray[np.float32]:
        """(N, ...) mean of what ticks hold from each row to the next; of the last row what its tick holds."""
        first = np.minimum(self.ticks + 1, len(values) - 1)
        last = np.append(self.ticks[1:], len(values) - 1)
        sums = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
        count = np.maximum(last + 1 - first, 1)
        means = (sums[first + count] - sums[first]) / count[:, None]
        return np.where((count == 1)[:, None], values[first], means).astype(np.float32)

    def samples(self, received: NDArray[np.float64]) -> NDArray[np.int64]:
        """(N,) the last sample that was at hand at each row; the first, where none was yet."""
        return last_before(received, self.time)


def last_before(stamps: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.int64]:
    """(N,) index of the last stamp at or before each time; 0 where there is none."""
    half_a_nanosecond = 5e-10  # stamps are whole nanoseconds
    return np.maximum(np.searchsorted(stamps, at + half_a_nanosecond, side="right") - 1, 0)
