"""What a robot recorded: scans, and where its odometry had it at each of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from threewe._arguments import LONGEST
from threewe._core import LaserScan, Pose2D, check_reading
from threewe.errors import ContractError

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 to 1."""


@dataclass
class Log:
    """Scans of one lidar in order of time, whatever the file was."""

    times: list[float] = field(default_factory=list)  # [s], of each scan; increasing
    scans: list[LaserScan] = field(default_factory=list)
    odometry: list[Pose2D] = field(default_factory=list)  # odom_from_base at each scan
    base_from_lidar: Pose2D = field(default_factory=Pose2D)
    skipped: dict[str, int] = field(default_factory=dict)  # why lines or messages were left out -> how many
    clock: str = ""  # where `times` are not the stamps that relations refer to: what they are, and why, with file:line

    def skip(self, reason: str) -> None:
        """Counts something that was left out."""
        self.skipped[reason] = self.skipped.get(reason, 0) + 1

    def add(self, time: float, scan: LaserScan, odometry: Pose2D) -> None:
        """A scan; one that is no later than the last is skipped. Numbers that no `Slam` can take raise
        ContractError.
        """
        check_reading(scan, odometry)
        if self.times and not abs(time - self.times[0]) <= LONGEST:
            raise ContractError(f"a time of {time:g} s after one of {self.times[0]:g} s")
        if self.times and time <= self.times[-1]:
            self.skip("scans no later than the one before")
            return
        self.times.append(time)
        self.scans.append(scan)
        self.odometry.append(odometry)

    @property
    def seconds(self) -> float:
        """[s] from the first scan to the last."""
        return self.times[-1] - self.times[0] if self.times else 0.0

    @property
    def distance(self) -> float:
        """[m] that the robot drove, by its odometry."""
        places = np.array([[pose.x, pose.y] for pose in self.odometry]).reshape(-1, 2)
        return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def write_tum(path: Path, trajectory: NDArray[np.float64]) -> None:
    """Writes (N, 4) time, x, y, heading in the format of the TUM RGB-D benchmark: t x y z qx qy qz qw."""
    with path.open("w", encoding="utf-8") as file:
        file.write("# timestamp tx ty tz qx qy qz qw\n")
        for time, x, y, theta in trajectory:
            file.write(f"{time:.6f} {x:.6f} {y:.6f} 0 0 0 {np.sin(theta / 2):.9f} {np.cos(theta / 2):.9f}\n")
