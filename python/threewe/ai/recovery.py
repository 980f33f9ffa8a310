"""Recovery of a robot that a policy drives against what its picture does not show."""

from __future__ import annotations

from typing import TYPE_CHECKING

from threewe._core import Intervention, PolicyRecovery, TickView, Velocity

if TYPE_CHECKING:
    from threewe.robot import Robot


class Recovery:
    """Of one run: what the policy wants, or to move away from what the gate has stopped the robot for.

    It observes the robot: `robot.observe(recovery.see)`.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._recovery = PolicyRecovery(robot.profile)
        self._stopped = False  # in the newest tick, by what is in the way

    @property
    def count(self) -> int:
        """How often it has moved away."""
        return self._recovery.count

    def next(self, now: float, wanted: Velocity) -> Velocity:
        """What to ask of the robot at this time [s]."""
        seeing = self._stopped and self._robot.profile.lidar is not None
        scan = self._robot.get_lidar_scan() if seeing else None
        return self._recovery.next(now, wanted, self._stopped, scan)

    def see(self, tick: TickView) -> None:
        """What the gate has made of what was asked."""
        self._stopped = tick.intervention is Intervention.stopped_for_obstacle and tick.commanded == Velocity()
