"""Journals of the recorder, mapped anew: close to the truth, and like the map that the robot made while it drove."""

from __future__ import annotations

import asyncio
import shutil
from dataclasses import dataclass
from pathlib import Path

import command_line
import numpy as np
import pytest
from numpy.typing import NDArray
from threewe import ConfigError, OccupancyGrid, Robot
from threewe.data import Recording, TrajectoryRecorder
from threewe.slam.formats import read_log
from threewe.slam.replay import Replay, replay

SEED = 7


@dataclass
class Drive:
    folder: Path
    own_map: OccupancyGrid


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Drive:
    """A noisy robot explores a flat for 20 s."""
    folder = tmp_path_factory.mktemp("journal") / "drive"

    async def main() -> OccupancyGrid:
        async with Robot(scene="apartment_v1", hardware="3we_standard_v2", seed=SEED) as robot:
            with TrajectoryRecorder(robot, folder, sensors=["lidar"]) as recorder:
                recorder.start_episode()
                await robot.explore(timeout=20.0)
                recorder.end_episode()
            return robot.get_map()

    return Drive(folder, asyncio.run(main()))


@pytest.fixture(scope="module")
def mapped(drive: Drive) -> Replay:
    return replay(read_log(drive.folder))


def at(times: NDArray[np.float64], stamps: NDArray[np.float64], poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """x, y at some times."""
    return np.stack([np.interp(times, stamps, poses[:, axis]) for axis in (0, 1)], axis=1)


def error(found: NDArray[np.float64], true: NDArray[np.float64]) -> float:
    """[m] root mean square, after the best rigid alignment."""
    a, b = found - found.mean(axis=0), true - true.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    rotation = u @ np.diag([1.0, np.linalg.det(u @ v)]) @ v
    return float(np.sqrt(((a @ rotation - b) ** 2).sum(axis=1).mean()))


def test_every_scan_gets_the_odometry_of_its_first_beam(drive: Drive) -> None:
    log, episode = read_log(drive.folder), Recording(drive.folder)[0]
    lidar = episode.lidar()
    assert len(log.scans) + sum(log.skipped.values()) == len(lidar)
    assert sum(log.skipped.values()) <= 2
    np.testing.assert_allclose(
        [[pose.x, pose.y] for pose in log.odometry], at(np.array(log.times), episode.time, episode.odom_from_base)
    )
    np.testing.assert_array_equal(log.scans[-1].ranges, lidar.ranges[-1])
    assert log.base_from_lidar.x > 0.0


def test_the_trajectory_is_closer_to_the_truth_than_odometry(drive: Drive, mapped: Replay) -> None:
    episode, times = Recording(drive.folder)[0], mapped.trajectory[:, 0]
    assert episode.true_pose is not None
    true = at(times, episode.time, episode.true_pose)
    assert mapped.outside == 0
    found = error(mapped.trajectory[:, 1:3], true)
    assert found < 0.02
    assert found < error(at(times, episode.time, episode.odom_from_base), true)


def test_the_map_is_like_the_robots_own(drive: Drive, mapped: Replay) -> None:
    """Of the cells that both know, 97 of 100 are free in both or occupied in both."""
    own, anew = drive.own_map, mapped.map
    shift = np.round((np.array(anew.origin) - own.origin) / own.resolution).astype(int)
    left, low = np.maximum(shift, 0)
    right, high = np.minimum(np.array([anew.width, anew.height]) + shift, (own.width, own.height))
    ours = own.data[low:high, left:right]
    theirs = anew.data[low - shift[1] : high - shift[1], left - shift[0] : right - shift[0]]
    known = (ours >= 0) & (theirs >= 0)
    assert known.sum() > 0.9 * (ours >= 0).sum()
    assert ((ours > 50) == (theirs > 50))[known].mean() > 0.97


def test_the_command_maps_a_journal(drive: Drive, tmp_path: Path) -> None:
    (journal,) = drive.folder.glob("*.journal")
    done = command_line.threewe("slam", "replay", str(journal), "-o", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out/map.pgm").exists()


def test_what_cannot_be_mapped_is_one_error(drive: Drive, tmp_path: Path) -> None:
    (journal,) = drive.folder.glob("*.journal")
    for number in (0, 1):
        shutil.copy(journal, tmp_path / f"episode_00000{number}.journal")
    with pytest.raises(ConfigError, match=r"2 journals; name one, such as .*episode_000000.journal"):
        read_log(tmp_path)
    (tmp_path / "broken.journal").write_bytes(journal.read_bytes()[:100])
    with pytest.raises(ConfigError, match=r"broken\.journal"):
        read_log(tmp_path / "broken.journal")


def test_a_recording_without_scans_is_one_error(tmp_path: Path) -> None:
    async def main() -> None:
        async with Robot(scene="apartment_v1", hardware="3we_standard_v2") as robot:
            with TrajectoryRecorder(robot, tmp_path / "blind", sensors=["imu"]) as recorder:
                recorder.start_episode()
                await robot.sleep(0.2)
                recorder.end_episode()

    asyncio.run(main())
    with pytest.raises(ConfigError, match="has no scans"):
        read_log(tmp_path / "blind")
