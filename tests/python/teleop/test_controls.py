"""What a person asks for, as a velocity."""

from __future__ import annotations

import math

import numpy as np
import pytest
from threewe import ContractError, RobotProfile, Velocity
from threewe.teleop import CombinedInput, Command, Connection, Controls, Drive, Event, SpeedLevel

HOLONOMIC = RobotProfile.load("3we_standard_v2")
DIFFERENTIAL = RobotProfile.load("turtlebot_like")


def test_full_ahead_at_full_speed_is_the_operating_limit() -> None:
    controls = Controls(HOLONOMIC, level=9)
    controls.apply([Drive(ahead=1.0)])
    assert controls.velocity() == Velocity(HOLONOMIC.operating_limits.linear, 0.0, 0.0)


@pytest.mark.parametrize("seed", range(50))
def test_no_direction_exceeds_the_speed_that_is_chosen(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for profile in (HOLONOMIC, DIFFERENTIAL):
        controls = Controls(profile)
        controls.apply([SpeedLevel(int(rng.integers(1, 10))), Drive(*rng.uniform(-1.0, 1.0, 3))])
        velocity = controls.velocity()
        assert math.hypot(velocity.vx, velocity.vy) <= controls.linear_speed * (1.0 + 1e-12), f"seed {seed}"
        assert abs(velocity.omega) <= controls.angular_speed, f"seed {seed}"


def test_sideways_turns_a_robot_that_cannot_go_sideways() -> None:
    controls = Controls(DIFFERENTIAL)
    controls.apply([Drive(ahead=1.0, left=1.0)])
    velocity = controls.velocity()
    assert velocity.vy == 0.0
    assert velocity.omega == controls.angular_speed


def test_speeds_end_at_the_slowest_and_the_fastest() -> None:
    controls = Controls(HOLONOMIC, level=8)
    controls.apply([Command.faster] * 5)
    assert controls.level == 9
    controls.apply([Command.slower] * 20)
    assert controls.level == 1
    with pytest.raises(ContractError, match="from 1 to 9"):
        Controls(HOLONOMIC, level=0)


@pytest.mark.parametrize(
    ("event", "wants"),
    [
        (Drive(turn=0.1), True),
        (Drive(), False),
        (Command.stop, True),
        (Command.emergency_stop, True),
        (Connection(False, ""), True),
        (Connection(True, ""), False),
        (Command.faster, False),
        (Command.start_episode, False),
    ],
)
def test_who_drives_stops_or_loses_the_device_takes_over(event: Event, wants: bool) -> None:
    assert Controls(HOLONOMIC).apply([event])[1] == wants


def test_two_devices_add_up_and_stay_in_range() -> None:
    first, second = Device([Drive(ahead=0.6)]), Device([Drive(ahead=0.7, turn=-0.5)])
    both = CombinedInput([first, second])
    assert both.poll(0.0)[-1] == Drive(ahead=1.0, turn=-0.5)
    first.events = [Drive()]
    second.events = []
    assert both.poll(0.1) == [Drive(ahead=0.7, turn=-0.5)]
    both.close()
    assert first.closed
    assert second.closed


class Device:
    def __init__(self, events: list[Event]) -> None:
        self.events, self.closed = events, False

    def poll(self, now: float) -> list[Event]:  # noqa: ARG002
        return self.events

    def close(self) -> None:
        self.closed = True
