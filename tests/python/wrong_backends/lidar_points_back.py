"""Beam 0 points backwards, yet is said to point forwards.

fails: lidar_sees_the_robot_drive_forward, the_lidar_is_where_the_profile_says
"""

from collections.abc import Iterator
from dataclasses import replace

from threewe.backend import LidarReading, Reading
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def readings(self, state: State) -> Iterator[Reading]:
        for reading in super().readings(state):
            yield replace(reading, angle_min=0.0) if isinstance(reading, LidarReading) else reading
