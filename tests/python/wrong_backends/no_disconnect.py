"""Nothing lets go of the robot."""

from collections.abc import Iterable

import threewe
from threewe import Features, Velocity
from threewe.backend import Backend, Reading


class Wrong(Backend):
    @property
    def features(self) -> Features:
        return Features([], self.profile.kinematics)

    def connect(self) -> None:
        pass

    def step(self, t: float, velocity: Velocity) -> Iterable[Reading]:
        raise NotImplementedError


threewe.register_backend("wrong", lambda options: Wrong(options))  # error: abstract
