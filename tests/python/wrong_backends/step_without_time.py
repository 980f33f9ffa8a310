"""The time that `step` is told is thought to be of no use."""

from collections.abc import Iterable

from threewe import Velocity
from threewe.backend import Reading
from toy import TICK, ToyBackend


class Wrong(ToyBackend):
    def step(self, velocity: Velocity) -> Iterable[Reading]:  # error: override
        return super().step(self.state.ticks * TICK, velocity)
