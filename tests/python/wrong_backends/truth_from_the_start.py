"""The true pose is counted from where the robot started, not in the frame of the scene.

fails: the_robot_starts_at_the_commanded_pose, reset_puts_the_robot_at_its_pose
"""

from dataclasses import replace

from threewe import Pose2D
from threewe.backend import Truth
from toy import ToyBackend


class Wrong(ToyBackend):
    def truth(self) -> Truth:
        return replace(super().truth(), start=Pose2D(), pose=self.start.inverse() * self.state.pose)
