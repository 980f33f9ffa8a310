"""The motors' y axis points to the right.

fails: sideways_is_left
"""

from collections.abc import Iterator

from threewe import Velocity
from threewe.backend import Reading
from toy import ToyBackend


class Wrong(ToyBackend):
    def step(self, t: float, velocity: Velocity) -> Iterator[Reading]:
        return super().step(t, Velocity(velocity.vx, -velocity.vy, velocity.omega))
