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

from threewe._core import OccupancyGrid, SlamConfig
from threewe.slam.log import Log, Progress, write_tum
from threewe.slam.mapper import Slam
from threewe.slam.relations import Accuracy, Relations
from threewe.slam.ros_map import save_map


@dataclass(frozen=True)
class Replay:
    """What came of a log."""

    log: Log
    map: OccupancyGrid
    trajectory: NDArray[np.float64]  # (N, 4) time as in the log [s], x [m], y [m], heading [rad]
    closures: Relations  # the places that were recognised, times as in the log
    computing_seconds: float  # of one core, for adding all scans and drawing the map; not for reading and writing files

    def summary(self, accuracy: Accuracy | None = None) -> dict[str, Any]:
        """The figures, as summary.json has them."""
        driven = np.linalg.norm(np.diff(self.trajectory[:, 1:3], axis=0), axis=1).sum()
        return {
            "scans": len(self.log.scans),
            "beams": len(self.log.scans[0].ranges),
            "skipped": self.log.skipped,
            "base_from_lidar": list(self.log.base_from_lidar),
            "data_seconds": round(self.log.seconds, 3),
            "computing_seconds": round(self.computing_seconds, 4),
            "data_seconds_per_second": round(self.log.seconds / max(self.computing_seconds, 1e-9), 1),
            "distance": round(float(driven), 3),
            "odometry_distance": round(self.log.distance, 3),
            "loop_closures": len(self.closures.times),
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
    return Replay(log, grid, trajectory, Relations(closures.times + begin, closures.poses), seconds)
