"""The beams come clockwise, as the device measures them, and are not put into order.

fails: lidar_sees_the_robot_turn_left
"""

import numpy as np
from numpy.typing import NDArray
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def scan(self, state: State) -> NDArray[np.float32]:
        return super().scan(state)[::-1]
