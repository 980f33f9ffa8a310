"""The mapper itself."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from threewe import _core
from threewe._arguments import PoseLike, as_pose, as_seconds
from threewe._core import LaserScan, OccupancyGrid, Pose2D, SlamConfig, SlamEvent
from threewe.errors import ContractError
from threewe.slam.relations import Relations

logger = logging.getLogger("threewe")

MEANING = {
    "lidar_frozen": "scans repeat to the bit while odometry moves: they are left out, odometry goes on alone",
    "odometry_jumped": "scans contradict a step of the odometry, such as a reset to zero: it is left out",
    "odometry_stopped": "scans move while odometry does not: they go on alone",
    "odometry_scaled": "odometry drives farther or less far than scans do, by one factor: its steps are corrected",
    "track_lost": "scans fit nowhere near, as of a kidnapped robot: a component of its own begins, "
    "which is no part of the map until the robot is recognised in it",
    "components_joined": "the robot was recognised in another component: the two are one from now on",
}
"""Of the incidents of `Slam.events()`, and what the mapper does then."""


class Slam:
    """Simultaneous localisation and mapping from scans of any field of view, and odometry as poses.

    The frame `map` begins where the robot is at the first scan. Neither sensor is trusted blindly: what is wrong with
    them is logged as a warning when it begins, and listed by `events()`. One thread at a time may use a Slam; a second
    one gets ContractError.
    """

    def __init__(self, config: SlamConfig | None = None) -> None:
        """What is known about the robot beforehand; a figure out of its range raises ContractError."""
        self._core = _core.Slam(config or SlamConfig())
        self._time: float | None = None

    def add(self, scan: LaserScan, odometry: PoseLike | None, time: float | None = None) -> Pose2D:
        """One scan, and where odometry had the robot as its first beam was measured; returns where the robot is.

        Without odometry, None, scans alone tell how the robot moves, which takes that they overlap a lot.

        `time` [s] of that beam; one second after the scan before, if it is left out. What is wrong, such as a NaN,
        another number of ranges than before, or a time that does not go on, raises ContractError and changes nothing.
        """
        if not isinstance(scan, LaserScan):
            raise ContractError(f"scan must be a LaserScan, got {scan!r}")
        if time is None:
            time = 0.0 if self._time is None else self._time + 1.0
        place = None if odometry is None else as_pose("odometry", odometry)
        pose, events = self._core.add(as_seconds("time", time), scan, place)
        self._time = time
        for event in events:
            logger.warning("Slam at %.3f s: %s: %s", event.begin, event.incident, MEANING[event.incident])
        return pose

    def map(self, component: int = 0) -> OccupancyGrid:
        """The map so far, drawn afresh from all scans of a component of the pose graph: by default the one in which the
        map began; see `components`.
        """
        return self._core.map(component)

    def trajectory(self) -> NDArray[np.float64]:
        """(N, 4) time [s], x [m], y [m], heading [rad] at each scan, as it is known now: what `add` returned may have
        been corrected since.
        """
        return self._core.trajectory()

    def components(self) -> NDArray[np.int64]:
        """(N,) the component of the pose graph that each scan of the trajectory belongs to; 0 is the map's. No
        measurement relates components: poses of one that is not 0 lie where the robot was last believed to be.
        """
        return np.array(self._core.components(), dtype=np.int64)

    def events(self) -> list[SlamEvent]:
        """What was wrong with the input since this Slam was made or loaded, in order of time; see `MEANING`."""
        return self._core.events()

    def closures(self) -> Relations:
        """The places that were recognised by comparing scans: at which two times, and where the robot was at the later
        one, seen from where it was at the earlier one. Compare them with the truth by `relation_errors`.
        """
        rows = self._core.closures()
        return Relations(rows[:, :2], rows[:, 2:])

    def save(self, path: Path | str) -> None:
        """Keeps the map in a file with all that is behind it: configuration, pose graph, scans and trajectory, without
        losing a bit. Raises ConfigError when it cannot be written; a file that was there then stays as it was.
        """
        self._core.save(str(path))

    @staticmethod
    def load(path: Path | str, pose: PoseLike | None = None) -> Slam:
        """A map that was kept, to be looked at or to go on with: odometry and lidar may be others then, time goes on.

        The next scan is taken at `pose` in the map, half a metre and ten degrees off at most; without one, where the
        last was taken. Raises ConfigError with file:line when the file is wrong.
        """
        slam = Slam.__new__(Slam)
        slam._core = _core.Slam.load(str(path), None if pose is None else as_pose("pose", pose))
        slam._time = float(slam._core.trajectory()[-1, 0])
        return slam
