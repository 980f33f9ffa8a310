"""Environment of LeRobot: a robot of 3we goes to things that are in sight. `lerobot-eval --env.type=threewe`.

LeRobot finds this package by its name. An episode is one of `threewe policy eval`, success is by the same rule: the
policy stands still for 0.5 s, within 1 m of a thing of the kind and with it in view.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.envs.configs import EnvConfig
from threewe import Velocity
from threewe._core import DriveLog, instruction_embedding
from threewe.ai.agent import LIMIT
from threewe.ai.evaluating import Evaluation, episodes_of
from threewe.ai.recovery import Recovery
from threewe.ai.runner import STANDS, STILL
from threewe.benchmark.attempt import Settings
from threewe.benchmark.buildings import scene_asset
from threewe.benchmark.tasks import TASKS, place_of, score
from threewe.sync import Robot

ID = "lerobot_env_threewe/objectnav"
NUMBERS = ("vx", "vy", "omega")


class ObjectNavEnv(gymnasium.Env):
    """One episode after the other; the seed of `reset` is its number."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012

    def __init__(
        self,
        episodes: str,
        count: int,
        backend: str,
        randomization: str,
        size: tuple[int, int],
        fps: int,
        render_mode: str | None = None,
    ) -> None:
        self.render_mode, self._size, self._period = render_mode, size, 1 / fps
        self.metadata = {**self.metadata, "render_fps": fps}
        self._settings = Settings(backend=backend, randomization=randomization)
        self._episodes = episodes_of(Evaluation(episodes=episodes, count=count), 0)
        self._task = TASKS["objectnav"]
        self._max_episode_steps = round(LIMIT * fps)
        self._robot: Robot | None = None
        self.task = self.task_description = ""
        picture = gymnasium.spaces.Box(0, 255, (*size, 3), np.uint8)
        self.observation_space = gymnasium.spaces.Dict(
            {
                "pixels": gymnasium.spaces.Dict({"camera": picture}),
                "environment_state": gymnasium.spaces.Box(-1, 1, (64,), np.float32),
                "agent_pos": gymnasium.spaces.Box(-10, 10, (3,), np.float32),
            }
        )
        self.action_space = gymnasium.spaces.Box(-10, 10, (3,), np.float32)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begins the episode of that number, the next one where left out."""
        super().reset(seed=seed, options=options)
        self.close()
        number = seed if seed is not None else int(self.np_random.integers(len(self._episodes)))
        episode = self._episode = self._episodes[number % len(self._episodes)]
        robot = self._robot = Robot(
            self._settings.backend,
            self._settings.hardware,
            scene_asset(episode.scene),
            noise=self._settings.noise,
            seed=episode.seed,
            start_pose=episode.start,
            randomization=self._settings.randomization,
            image_size=self._size,
        )
        self._log = robot._thread.call(lambda: DriveLog(robot._target._world))
        robot.connect()
        self._recovery = Recovery(robot._target)
        robot._thread.call(lambda: robot._target.observe(self._recovery.see))
        self.task = self.task_description = f"go to the {episode.category}"
        self._embedding = np.array(instruction_embedding(self.task), np.float32)
        self._still = 0.0
        return self._observation(), {"is_success": False}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Drives with a velocity (vx, vy, omega) [m/s, m/s, rad/s] until the next observation.

        Where the gate has stopped the robot for half a second it moves a little away first, as under `VLARunner`.
        """
        robot = self._robot
        assert robot is not None
        vx, vy, omega = (float(number) for number in action)
        velocity = robot._thread.call(lambda: self._recovery.next(robot._target.now, Velocity(vx, vy, omega)))
        robot.set_velocity(*velocity, hold=self._period)
        robot.sleep(self._period)
        standing = np.hypot(vx, vy) <= STANDS[0] and abs(omega) <= STANDS[1]
        self._still = self._still + self._period if standing else 0.0
        stopped = self._still >= STILL - 1e-9
        late = robot.now >= min(LIMIT, self._task.time_limit(self._episode))
        success = False
        if stopped or late:
            robot._thread.call(self._log.end)
            place = place_of(self._episode.scene, self._settings.hardware)
            end = "stop" if stopped else "time"
            success = score(self._task, self._episode, place, self._log, end)["success"] > 0.5
        return self._observation(), float(success), stopped, late and not stopped, {"is_success": success}

    def render(self) -> Any:
        """The camera's picture, RGB."""
        return self._observation()["pixels"]["camera"]

    def close(self) -> None:
        """Ends the robot's world."""
        if self._robot is not None:
            self._robot.disconnect()
            self._robot = None

    def _observation(self) -> dict[str, Any]:
        assert self._robot is not None
        velocity = self._robot.get_velocity()
        return {
            "pixels": {"camera": np.ascontiguousarray(self._robot.get_image()[:, :, ::-1])},
            "environment_state": self._embedding,
            "agent_pos": np.array([getattr(velocity, name) for name in NUMBERS], np.float32),
        }


@EnvConfig.register_subclass("threewe")
@dataclass
class ThreeweEnv(EnvConfig):
    """`--env.episodes=in_sight_v1 --env.count=100 --env.backend=mock ...`; `--seed` is the first episode's number."""

    task: str | None = "objectnav"
    fps: int = 10
    episodes: str = "generated"
    count: int = 20
    backend: str = "mock"
    randomization: str = "none"
    height: int = 60
    width: int = 80
    features: dict[str, PolicyFeature] = field(default_factory=dict)
    features_map: dict[str, str] = field(
        default_factory=lambda: {
            "action": "action",
            "agent_pos": "observation.state",
            "environment_state": "observation.environment_state",
            "pixels/camera": "observation.images.camera",
        }
    )

    def __post_init__(self) -> None:
        self.features = {
            "action": PolicyFeature(FeatureType.ACTION, (3,)),
            "agent_pos": PolicyFeature(FeatureType.STATE, (3,)),
            "environment_state": PolicyFeature(FeatureType.ENV, (64,)),
            "pixels/camera": PolicyFeature(FeatureType.VISUAL, (self.height, self.width, 3)),
        }

    @property
    def package_name(self) -> str:
        """This one."""
        return "lerobot_env_threewe"

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        """Of the environment."""
        options = {"episodes": self.episodes, "count": self.count, "backend": self.backend, "fps": self.fps}
        return {**options, "randomization": self.randomization, "size": (self.height, self.width)}


if ID not in gymnasium.registry:
    gymnasium.register(ID, entry_point=ObjectNavEnv)
