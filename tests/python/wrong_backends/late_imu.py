"""The inertial unit's readings come 0.3 s late, and are stamped as they arrive.

fails: imu_and_odometry_are_of_one_time, a_restored_world_has_the_same_future
"""

from collections.abc import Iterator
from dataclasses import replace

from threewe.backend import BackendOptions, IMUReading, Reading
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.held: list[IMUReading] = []

    def readings(self, state: State) -> Iterator[Reading]:
        if state.ticks == 1:
            self.held = []
        for reading in super().readings(state):
            if isinstance(reading, IMUReading):
                self.held.append(reading)
            else:
                yield reading
        now = state.ticks / 100
        while self.held and self.held[0].measured <= now - 0.3 + 1e-9:
            yield replace(self.held.pop(0), measured=now)
