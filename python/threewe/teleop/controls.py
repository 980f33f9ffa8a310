"""What a person has asked for so far: direction, speed and whether the person drives at all."""

from __future__ import annotations

import math
from collections.abc import Iterable

from threewe._core import Kinematics, RobotProfile, Velocity
from threewe.errors import ContractError
from threewe.teleop.events import Command, Connection, Drive, Event, SpeedLevel

LEVELS = 9
"""Speed levels; the highest is the operating limits of the robot."""


class Controls:
    """Turns events into velocities of one robot, without a device, a clock or a robot.

    Args:
        profile: what the robot is. On a differential base, which cannot go sideways, left and right turn it.
        level: the speed in the beginning, 1 to 9 ninths of the operating limits.

    Raises:
        ContractError: a level that is none.
    """

    def __init__(self, profile: RobotProfile, level: int = 5) -> None:
        if level not in range(1, LEVELS + 1):
            raise ContractError(f"speed must be a whole number from 1 to {LEVELS}, got {level!r}")
        self._limits = profile.operating_limits
        self._sideways = profile.kinematics is not Kinematics.differential
        self.level = level
        """1 to 9."""
        self.drive = Drive()
        """The direction that was asked for last."""

    def apply(self, events: Iterable[Event]) -> tuple[list[Command], bool]:
        """Takes note of what happened.

        Returns:
            The commands that are left for others to follow, and whether the person wants to drive: a direction was
            given, or a stop, or the device was lost, which stops a policy, too.
        """
        left: list[Command] = []
        wants = False
        for event in events:
            match event:
                case Drive():
                    self.drive = event
                    wants |= bool(event)
                case SpeedLevel():
                    self.level = max(1, min(LEVELS, event.level))
                case Command.faster:
                    self.level = min(LEVELS, self.level + 1)
                case Command.slower:
                    self.level = max(1, self.level - 1)
                case Connection():
                    self.drive = Drive()
                    wants |= not event.connected
                case Command():
                    if event in (Command.stop, Command.emergency_stop):
                        self.drive = Drive()
                        wants = True
                    left.append(event)
        return left, wants

    @property
    def linear_speed(self) -> float:
        """[m/s] at the level that is chosen."""
        return self._limits.linear * self.level / LEVELS

    @property
    def angular_speed(self) -> float:
        """[rad/s] at the level that is chosen."""
        return self._limits.angular * self.level / LEVELS

    def velocity(self) -> Velocity:
        """The body velocity [m/s, m/s, rad/s] to drive at; full ahead and full left is no faster than one of them."""
        ahead, left, turn = self.drive.ahead, self.drive.left, self.drive.turn
        if not self._sideways:
            turn, left = max(-1.0, min(1.0, turn + left)), 0.0
        shorten = max(1.0, math.hypot(ahead, left))
        linear = self.linear_speed / shorten
        return Velocity(ahead * linear, left * linear, turn * self.angular_speed)
