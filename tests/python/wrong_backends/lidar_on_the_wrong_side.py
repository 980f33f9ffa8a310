"""The simulated lidar is 4 cm behind the middle of the base; the profile has it 4 cm ahead.

fails: the_lidar_is_where_the_profile_says
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from threewe import Pose2D
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def scan(self, state: State) -> NDArray[np.float32]:
        return super().scan(replace(state, pose=state.pose * Pose2D(-0.08)))
