"""Journals of a `TrajectoryRecorder`: scans, and the odometry with gyro that the robot's own mapper was given."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from threewe._core import LaserScan, Pose2D
from threewe.data.mounts import profile_of
from threewe.data.recording import RecordedEpisode, Recording
from threewe.errors import ConfigError, ContractError
from threewe.slam.log import Log, Progress


def read_journal(path: Path, *, on_progress: Progress | None = None) -> Log:
    """Reads the scans of a journal's only robot, or of a folder's only journal. Where odometry had the robot is the
    recorded `odom_from_base`: wheels and gyro, without corrections by the map. Scans outside the ticks are skipped and
    counted. Raises ConfigError.
    """
    episode = _only_episode(path)
    if "lidar" not in episode.sensors or not len(lidar := episode.lidar()):
        raise ConfigError(f"{episode.file}: has no scans; it has {', '.join(episode.sensors)}")
    spec = profile_of(episode).lidar
    if spec is None:
        raise ConfigError(f"{episode.file}: the profile '{episode.robot_type}' has no lidar, but there are scans")
    log = Log(base_from_lidar=spec.base_from_lidar)
    x, y, theta = episode.odom_from_base.T
    theta = np.unwrap(theta)
    for i, time in enumerate(lidar.measured.tolist()):
        if len(episode.time) == 0 or not episode.time[0] <= time <= episode.time[-1]:
            log.skip("scans without odometry around them")
            continue
        place = Pose2D(*(float(np.interp(time, episode.time, values)) for values in (x, y, theta)))
        limits = lidar.range_min, lidar.range_max, lidar.time_increment
        try:
            log.add(time, LaserScan(lidar.ranges[i], lidar.angle_min, lidar.angle_increment, *limits), place)
        except ContractError as error:
            raise ConfigError(f"{episode.file}: scan {i}: {error}") from None
        if on_progress:
            on_progress(i / len(lidar))
    if not log.scans:
        raise ConfigError(f"{episode.file}: no scan was measured between its first and its last tick")
    return log


def _only_episode(path: Path) -> RecordedEpisode:
    """Raises ConfigError where there are several: where one ends and the next begins, a robot may have been moved."""
    recording = Recording(path)
    episodes = list(recording)
    files = {episode.file for episode in episodes}
    if len(files) > 1:
        raise ConfigError(f"{path}: {len(files)} journals; name one, such as {min(files)}")
    if len(episodes) > 1:
        raise ConfigError(f"{path}: {len(episodes)} robots in it; a map is made of the scans of one")
    return episodes[0]
