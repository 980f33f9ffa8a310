"""A reset puts the robot back, but goes on with the noise that comes next.

fails: reset_with_the_same_seed_repeats
"""

from threewe import Pose2D
from toy import ToyBackend


class Wrong(ToyBackend):
    def reset(self, seed: int, pose: Pose2D | None) -> None:
        noise = self.state.noise
        super().reset(seed, pose)
        self.state.noise = noise
