"""The gyro's datasheet speaks of degrees.

fails: gyro_agrees_with_odometry
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from threewe.backend import IMUReading, Reading
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def readings(self, state: State) -> Iterator[Reading]:
        for reading in super().readings(state):
            if isinstance(reading, IMUReading):
                reading = replace(reading, angular_velocity=np.degrees(reading.angular_velocity))
            yield reading
