"""Tells what a policy sees from how its robot moves: it drives on one backend, and sees the pictures of another."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from threewe import Pose2D, Robot, Velocity
from threewe.ai.agent import PolicyAgent
from threewe.ai.runner import TICK
from threewe.benchmark.attempt import Settings, attempt_with
from threewe.benchmark.buildings import scene_asset
from threewe.benchmark.episodes import Episode
from threewe.benchmark.sampling import generated_in_sight
from threewe.benchmark.tasks import Assignment, Place

from verify.harness import Case

BACKENDS = ("mock", "mujoco")


class SeesAnother(PolicyAgent):
    """The shipped policy, which gets the pictures of a robot of another world at the same pose, without noise."""

    privileged = True

    def __init__(self, pictures: str, scene: str) -> None:
        super().__init__("goto_v1")
        self._pictures, self._scene = pictures, scene

    @staticmethod
    def robot_options(episode: Episode, place: Place) -> dict[str, Any]:
        """As it is for an agent that is not privileged."""
        del episode, place
        return {}

    async def run(self, robot: Robot, assignment: Assignment) -> None:
        """Each picture is replaced by that of the other world, from where the robot was when it was measured."""
        assert robot.simulation is not None
        truth, start = robot.simulation, self._runner._start
        first = truth.true_pose()
        poses: dict[int, Pose2D] = {}
        robot.observe(lambda tick: poses.update({round(tick.now / TICK): truth.true_pose()}))
        size = self.options["image_size"]
        async with Robot(self._pictures, scene=scene_asset(self._scene), image_size=size) as other:
            assert other.simulation is not None
            camera, simulation = other.profile.camera, other.simulation
            assert camera is not None

            def seen(image: NDArray[np.uint8], instruction: str, velocity: Velocity, committed: list[Velocity]) -> Any:
                measured = round(robot._runtime.image_measured() / TICK)
                pose = poses.get(measured, first)  # before the first tick that is noted it stood there
                picture = simulation.look(pose=pose * camera.base_from_camera, with_itself=False).color
                assert picture.shape == image.shape
                return start(np.ascontiguousarray(picture), instruction, velocity, committed)

            self._runner._start = seen  # type: ignore[method-assign, assignment]
            await super().run(robot, assignment)


def see_another(seed: int) -> Case:
    """The same episode by each physics with each backend's pictures: where the policy gets there."""
    episode = next(generated_in_sight(f"verify/{seed}"))
    won: Case = {}
    for physics in BACKENDS:
        for pictures in BACKENDS:
            agent = SeesAnother(pictures, episode.scene)
            tried = attempt_with("objectnav", episode, agent, Settings(backend=physics))
            if tried["end"] == "failure" and not tried["failure"].startswith(("NavigationError", "TimeoutError")):
                raise RuntimeError(tried["failure"])  # not the policy's
            won[f"{physics}, {pictures}"] = bool(tried["metrics"]["success"])
    return won
