"""Export of the trajectories of a recording in the format of the TUM RGB-D benchmark, which evo reads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from threewe._arguments import as_switch
from threewe.data.exporting import OnProgress, TickedEpisodes, write_episodes
from threewe.data.recording import RecordedEpisode
from threewe.errors import ConfigError
from threewe.slam.log import write_tum

OPTIONS = ("truth",)


def write(
    episodes: TickedEpisodes, output: Path, fps: float, on_progress: OnProgress | None, *, truth: bool = False
) -> Path:
    """Writes EPISODE.tum, the pose in `map` at every tick by robot time; with `truth` also EPISODE.true.tum, the true
    pose in the scene. See `threewe.data.export`.
    """
    del fps  # every tick is kept
    wanted = as_switch("truth", truth)
    if wanted and output.suffix == ".tum":
        raise ConfigError(f"{output}: with the truth an episode has two files: name a folder")

    def write_one(episode: RecordedEpisode, file: Path) -> None:
        write_tum(file, _timed(episode, episode.pose))
        if wanted:
            if episode.true_pose is None:
                raise ConfigError(f"{episode.file}: a real robot has no true pose: leave out truth")
            write_tum(file.with_suffix(".true.tum"), _timed(episode, episode.true_pose))

    return write_episodes(episodes, output, ".tum", on_progress, write_one)


def _timed(episode: RecordedEpisode, poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, 4) time, x, y, heading."""
    return np.column_stack([episode.time, poses])
