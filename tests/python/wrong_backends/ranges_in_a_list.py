"""A scan is a list of numbers, and not an array of float32."""

from collections.abc import Iterator

from threewe.backend import LidarReading, Reading
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def readings(self, state: State) -> Iterator[Reading]:
        ranges = [float(r) for r in self.scan(state)]
        yield LidarReading(measured=state.ticks / 100, ranges=ranges)  # error: arg-type
