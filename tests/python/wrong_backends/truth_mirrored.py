"""The simulator's y axis points to the right, and its poses are passed on as they are.

fails: truth_agrees_with_odometry, truth_is_in_the_frame_of_the_scene, the_robot_starts_at_the_commanded_pose,
reset_puts_the_robot_at_its_pose
"""

from dataclasses import replace

from threewe import Pose2D
from threewe.backend import Truth
from toy import ToyBackend


class Wrong(ToyBackend):
    def truth(self) -> Truth:
        x, y, theta = self.state.pose
        return replace(super().truth(), pose=Pose2D(x, -y, -theta))
