"""Readings are what other libraries make of them: values by name."""

from collections.abc import Iterator

from threewe import Velocity
from threewe.backend import Reading
from toy import ToyBackend


class Wrong(ToyBackend):
    def step(self, t: float, velocity: Velocity) -> Iterator[Reading]:
        yield {"stamp": t, "velocity": velocity}  # error: misc
