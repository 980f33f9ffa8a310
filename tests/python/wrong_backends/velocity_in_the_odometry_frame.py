"""Odometry gives the velocity along the axes of its own frame, and not of the body.

fails: odometry_velocity_is_in_the_body_frame
"""

from collections.abc import Iterator
from dataclasses import replace

from threewe import Pose2D, Velocity
from threewe.backend import OdometryReading, Reading
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def readings(self, state: State) -> Iterator[Reading]:
        heading = Pose2D(theta=(self.start.inverse() * state.pose).theta)
        vx, vy = heading.transform((state.velocity.vx, state.velocity.vy))
        for reading in super().readings(state):
            if isinstance(reading, OdometryReading):
                reading = replace(reading, velocity=Velocity(vx, vy, state.velocity.omega))
            yield reading
