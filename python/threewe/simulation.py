"""The truth about a robot in a simulated world."""

from __future__ import annotations

from threewe import _core
from threewe._core import Pose2D, Snapshot
from threewe._time import RobotTime


class Simulation(_core.Simulation):
    """The truth about a robot in a simulated world, for metrics, drawings and training.

    All poses are in the scene's frame. The robot itself never sees it.
    """

    def __init__(self, world: _core.World, robot: int, robot_time: RobotTime) -> None:
        super().__init__(world, robot)
        self._time = robot_time

    def reset(self, *, seed: int = 0, pose: Pose2D | None = None) -> None:
        """Begins anew at time 0: motions end as `cancelled`, sleeps end.

        The robot starts at `pose`, or at the scene's own start pose without it. Raises ConfigError when that is inside
        an obstacle.
        """
        self._time.check_thread()
        super().reset(seed=seed, pose=pose)
        self._time.wake()

    def save(self) -> Snapshot:
        """Everything the future depends on. Raises ContractError while a motion is in progress."""
        self._time.check_thread()
        return super().save()

    def restore(self, snapshot: Snapshot) -> None:
        """Goes on from where `save` was called. Sleeps end."""
        self._time.check_thread()
        super().restore(snapshot)
        self._time.wake()
