"""A velocity of zero is taken for the absence of a command.

fails: an_expired_command_stops_the_robot, a_command_lasts_while_it_is_valid, a_refused_command_changes_nothing,
zero_stops_the_robot, a_stopped_robot_stands_still, a_metre_driven_is_a_metre_in_odometry, odometry_turns_left,
sideways_is_left, distance_driven_is_counted
"""

from collections.abc import Iterator

from threewe import Velocity
from threewe.backend import Reading
from toy import ToyBackend


class Wrong(ToyBackend):
    def step(self, t: float, velocity: Velocity) -> Iterator[Reading]:
        return super().step(t, velocity if velocity != Velocity() else self.state.velocity)
