"""The accelerometer's driver takes gravity out.

fails: imu_at_rest_measures_gravity_alone
"""

from collections.abc import Iterator
from dataclasses import replace

from threewe.backend import IMUReading, Reading
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def readings(self, state: State) -> Iterator[Reading]:
        for reading in super().readings(state):
            yield replace(reading, linear_acceleration=(0.0, 0.0, 0.0)) if isinstance(reading, IMUReading) else reading
