"""Headings run from 0 to 2 pi: the border refuses those beyond half a turn.

fails: imu_and_odometry_are_of_one_time, lidar_and_odometry_are_of_one_time,
heading_stays_within_pi, battery_is_a_fraction_and_never_rises
"""

import math
from collections.abc import Iterator
from dataclasses import replace

from threewe.backend import OdometryReading, Reading
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def readings(self, state: State) -> Iterator[Reading]:
        for reading in super().readings(state):
            if isinstance(reading, OdometryReading):
                x, y, theta = reading.pose
                reading = replace(reading, pose=(x, y, theta % math.tau))
            yield reading
