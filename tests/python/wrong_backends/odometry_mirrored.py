"""A differential robot without a truth whose odometry has y to the right.

fails: odometry_drives_where_it_heads
"""

from collections.abc import Iterator
from dataclasses import replace

from threewe import Pose2D, RobotProfile
from threewe.backend import Backend, BackendOptions, OdometryReading, Reading
from toy import State, ToyBackend


class Wrong(ToyBackend):
    truth = Backend.truth

    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.profile = RobotProfile.load("turtlebot_like")

    def readings(self, state: State) -> Iterator[Reading]:
        x, y, theta = self.start.inverse() * state.pose
        for reading in super().readings(state):
            yield replace(reading, pose=Pose2D(x, -y, theta)) if isinstance(reading, OdometryReading) else reading
