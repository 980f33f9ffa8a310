"""The features promise a battery that never says anything.

fails: every_sensor_delivers, rates_are_as_listed
"""

from collections.abc import Iterator

from threewe.backend import BatteryReading, Reading
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def readings(self, state: State) -> Iterator[Reading]:
        for reading in super().readings(state):
            if not isinstance(reading, BatteryReading):
                yield reading
