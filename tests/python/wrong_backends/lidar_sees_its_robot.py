"""Beams to the rear end at a post that stands on the robot.

fails: the_lidar_does_not_hit_the_robot
"""

import numpy as np
from numpy.typing import NDArray
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def scan(self, state: State) -> NDArray[np.float32]:
        ranges = super().scan(state)
        ranges[:6] = 0.12  # beam 0 looks back
        return ranges
