"""One environment."""

from __future__ import annotations

from typing import Any, Unpack

import gymnasium
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils import EzPickle

from threewe._arguments import as_seed
from threewe.gym.batch import Batch, EnvOptions, Observation, as_actions, make_batch, make_robot_env, with_limit
from threewe.gym.rendering import RENDER_MODES, make_onlooker


class Env(gymnasium.Env[Any, Any], EzPickle):
    """A task, as `gymnasium.make("3we/Navigation-v1")` makes it: in the embedded simulator, or around a `Robot`.

    Without a `backend` it is a batch of one: with the same seeds and actions, `VectorEnv` gives the same bits. With one
    it drives a robot there as `Robot.execute_action` does. An action is (3,) float32 in [-1, 1]: forward, left and
    counter-clockwise as shares of the robot's operating limits.

    `reset(options=...)` takes `start` (x, y, theta) and `goal` (x, y) in the scene's frame, `object_goal` of ObjectNav,
    `scene` (one of its own, by name) and `episode_number`, that of an episode since the seed was given: `info` names it
    and the seed, so that any episode can be repeated.

    Copies (`copy.deepcopy`, `pickle`) are new environments with the same arguments, and begin with a reset.

    Args:
        task: `navigation`, `exploration`, `object_nav`, `vln`.
        render_mode: `rgb_array`: `render()` returns the place from above, (H, W, 3) uint8 RGB; `human`: a window of
            the viewer shows it at the pace of the clock (where there is no display, a page whose address is printed).
        options: see `EnvOptions`.
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 10}  # noqa: RUF012

    def __init__(self, *, task: str, render_mode: str | None = None, **options: Unpack[EnvOptions]) -> None:
        EzPickle.__init__(self, task=task, render_mode=render_mode, **options)
        self._batch: Batch[Any]
        if options.get("backend") is None:
            self._batch = make_batch(task, num_envs=1, num_robots=1, num_threads=1, autoreset="disabled", **options)
        else:
            self._batch = make_robot_env(task, **options)
        self._core = self._batch.core
        self.observation_space = self._batch.observation_space
        self.action_space = self._batch.action_space
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": self._batch.options["control_rate"]}
        self._onlooker = make_onlooker(render_mode, self._batch)
        self._begun = False
        self._spec: EnvSpec | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode: the first of a seed, or the next one."""
        given = None if seed is None else as_seed("seed", seed)
        super().reset(seed=given)
        if given is None and not self._begun:
            given = int(self.np_random.integers(2**63))
        self._batch.reset([given], options, None)
        self._begun = True
        if self._onlooker:
            self._onlooker.begin()
        return self._batch.observation(0), self._batch.first_info()

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One control step. Raises ContractError, and does nothing, for an action that is none.

        Args:
            action: (3,) in [-1, 1]: shares of the operating limits forward, left and counter-clockwise.

        Returns:
            observation, reward, terminated, truncated, info.
        """
        self._core.step(as_actions(action, (3,)))
        if self._onlooker:
            self._onlooker.look()
        return (
            self._batch.observation(0),
            float(self._core.rewards[0]),
            bool(self._core.terminated[0]),
            bool(self._core.truncated[0]),
            self._batch.info(),
        )

    @property
    def spec(self) -> EnvSpec | None:
        """What the environment was made from, with `max_episode_steps`."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = with_limit(spec, self._batch.options["max_steps"])

    @property
    def metric_names(self) -> list[str]:
        """What `info` tells of how an episode goes."""
        return self._core.metric_names

    def render(self) -> Any:
        """The place from above, (H, W, 3) uint8 RGB, with `render_mode="rgb_array"`."""
        return self._onlooker.render() if self._onlooker else None

    def close(self) -> None:
        """Ends what `render_mode` began."""
        if self._onlooker:
            self._onlooker.close()
