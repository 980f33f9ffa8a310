"""`options.start_pose` is not obeyed.

fails: the_robot_starts_at_the_commanded_pose
"""

from threewe.backend import BackendOptions
from toy import ToyBackend


class Wrong(ToyBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.state = self.new_state(options.seed, None)
