"""A log, replayed: the map, the way, and what they cost."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import OccupancyGrid, SlamConfig, SlamEvent
from threewe.errors import ConfigError
from threewe.slam.log import Log, Progress, write_tum
from threewe.slam.mapper import Slam
from threewe.slam.relations import Accuracy, Relations, accuracy
from threewe.slam.ros_map import save_map


@dataclass(frozen=True)
class Replay:
    """What came of a log."""

    log: Log
    map: OccupancyGrid
    trajectory: NDArray[np.float64]  # (N, 4) time as in the log [s], x [m], y [m], heading [rad]
    closures: Relations  # the places that were recognised, times as in the log
    components: NDArray[np.int64]  # (N,) of the pose graph; scans of any but 0 are no part of the map
    events: list[SlamEvent]  # what was wrong with the log, times from its first scan [s]
    computing_seconds: float  # of one core, for adding all scans and drawing the map; not for reading and writing files

    @property
    def outside(self) -> int:
        """How many scans are no part of the map."""
        return int((self.components != 0).sum())

    def accuracy(self, relations: Relations) -> Accuracy:
        """How well the map fits what is known, where both places of a relation lie in it. Raises ConfigError where the
        log's times are not those that relations refer to, and where none of these lies within the map.
        """
        if self.log.clock:
            raise ConfigError(f"{self.log.clock}; relations refer to stamps")
        times = self.trajectory[:, 0]
        later = np.clip(np.searchsorted(times, relations.times), 1, max(len(times) - 1, 1))
        mapped = (self.components == 0)[np.clip([later - 1, later], 0, len(times) - 1)].all(axis=(0, 2))
        if not mapped.any():
            raise ConfigError("no relation is within the map")
        result = accuracy(self.trajectory, Relations(relations.times[mapped], relations.poses[mapped]))
        return dataclasses.replace(result, left_out=result.left_out + int((~mapped).sum()))

    def summary(self, accuracy: Accuracy | None = None) -> dict[str, Any]:
        """The figures, as summary.json has them."""
        driven = np.linalg.norm(np.diff(self.trajectory[:, 1:3], axis=0), axis=1).sum()
        return {
            "scans": len(self.log.scans),
            "beams": len(self.log.scans[0].ranges),
            "skipped": self.log.skipped,
            "clock": self.log.clock or "stamps",
            "base_from_lidar": list(self.log.base_from_lidar),
            "data_seconds": round(self.log.seconds, 3),
            "computing_seconds": round(self.computing_seconds, 4),
            "data_seconds_per_second": round(self.log.seconds / max(self.computing_seconds, 1e-9), 1),
            "distance": round(float(driven), 3),
            "odometry_distance": round(self.log.distance, 3),
            "loop_closures": len(self.closures.times),
            "events": [{"incident": e.incident, "begin": e.begin, "end": e.end, "scans": e.scans} for e in self.events],
            "scans_outside_map": self.outside,
            "map_size": [self.map.width * self.map.resolution, self.map.height * self.map.resolution],
            "accuracy": None if accuracy is None else dataclasses.asdict(accuracy),
        }

    def write(self, folder: Path, accuracy: Accuracy | None = None) -> None:
        """Leaves map.pgm, map.yaml, trajectory.tum and summary.json in a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        save_map(self.map, folder / "map.yaml")
        write_tum(folder / "trajectory.tum", self.trajectory)
        (folder / "summary.json").write_text(json.dumps(self.summary(accuracy), indent=2) + "\n", encoding="utf-8")


def replay(log: Log, config: SlamConfig | None = None, *, on_progress: Progress | None = None) -> Replay:
    """Maps a log. The lidar's place on the robot is the log's own, unless a config has another."""
    slam = Slam(config or SlamConfig(base_from_lidar=log.base_from_lidar))
    begin = log.times[0]  # clocks that count from 1970 are too coarse for nanoseconds
    seconds = 0.0
    for i, (time, scan, odometry) in enumerate(zip(log.times, log.scans, log.odometry, strict=True)):
        before = thread_time()
        slam.add(scan, odometry, time - begin)
        seconds += thread_time() - before
        if on_progress and i % 50 == 0:
            on_progress(i / len(log.scans))
    before = thread_time()
    grid = slam.map()
    seconds += thread_time() - before
    trajectory = slam.trajectory()
    trajectory[:, 0] = log.times
    closures = slam.closures()
    closures = Relations(closures.times + begin, closures.poses)
    return Replay(log, grid, trajectory, closures, slam.components(), slam.events(), seconds)
