"""Many environments at once."""

from __future__ import annotations

from typing import Any, Unpack

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils import EzPickle
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from threewe._arguments import as_seed
from threewe._core import EpisodeInfo
from threewe.errors import ConfigError, ContractError
from threewe.gym.batch import EnvOptions, Observation, as_actions, make_batch, with_limit

MODES = {
    AutoresetMode.NEXT_STEP: "next_step",
    AutoresetMode.SAME_STEP: "same_step",
    AutoresetMode.DISABLED: "disabled",
}


class VectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any], EzPickle):
    """A batch of environments in one process, as `gymnasium.make_vec("3we/Navigation-v1", num_envs=1024)` makes it.

    Environment i with seed s gives the same bits as `Env` with that seed, wherever it stands in the batch and on
    however many threads. `reset(seed=s)` seeds environment i with s + i. `reset(options={"reset_mask": mask})` resets
    some of them.

    One thread at a time uses a batch: a call during another one's raises ContractError. A process that is forked makes
    its own (with `num_threads=1` a batch can be taken along). Copies are new batches with the same arguments.

    Args:
        task: see `Env`.
        num_envs: how many.
        num_robots: a team of so many robots in each, see `MultiAgentEnv`. Everything has one more dimension then:
            observations, actions, rewards, flags and metrics are (num_envs, num_robots, ...). An episode is over when
            it is for all of its robots; `infos["active"]` tells whose still was not before the step.
        num_threads: that share the work.
        autoreset_mode: what happens after an episode's end: `NEXT_STEP` (Gymnasium's default), `SAME_STEP` (with
            `final_obs` and `final_info` in the infos), `DISABLED`.
        copy: whether observations, rewards, flags and metrics are copies. Without, they are views of C++ memory that
            the next call of `step` or `reset` overwrites.
        options: see `EnvOptions`.
    """

    def __init__(
        self,
        *,
        task: str,
        num_envs: int = 1,
        num_robots: int | None = None,
        num_threads: int = 1,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        copy: bool = True,
        render_mode: str | None = None,
        **options: Unpack[EnvOptions],
    ) -> None:
        EzPickle.__init__(
            self,
            task=task,
            num_envs=num_envs,
            num_robots=num_robots,
            num_threads=num_threads,
            autoreset_mode=autoreset_mode,
            copy=copy,
            render_mode=render_mode,
            **options,
        )
        mode = AutoresetMode(autoreset_mode)
        if render_mode is not None:
            raise ConfigError("render_mode: a batch is not drawn; use a single environment")
        self.metadata = {"autoreset_mode": mode, "render_modes": []}
        self._batch = make_batch(
            task,
            num_envs=num_envs,
            num_robots=1 if num_robots is None else num_robots,
            num_threads=num_threads,
            autoreset=MODES[mode],
            **options,
        )
        self._core = self._batch.core
        self._copy = copy
        self._same_step = mode == AutoresetMode.SAME_STEP
        self._begun = False
        self._spec: EnvSpec | None = None
        self._scene_names = np.array([scene.name for scene in self._batch.scenes], dtype=object)
        self._everyone = np.ones(num_envs, dtype=np.bool_)
        self.num_envs = num_envs
        self._team = () if num_robots is None else (num_robots,)
        self.single_observation_space = self._batch.observation_space
        self.single_action_space = self._batch.action_space
        if num_robots is not None:
            self.single_observation_space = batch_space(self.single_observation_space, num_robots)
            self.single_action_space = batch_space(self.single_action_space, num_robots)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        # views of C++ memory, made once
        core = self._core
        self._observations = {name: self._by_env(values) for name, values in core.observations.items()}
        self._final_observations = {name: self._by_env(values) for name, values in core.final_observations.items()}
        self._outcome = (self._by_env(core.rewards), self._by_env(core.terminated), self._by_env(core.truncated))
        self._done = self._by_env(core.done)
        self._metrics = np.moveaxis(self._by_env(core.metrics), -1, 0)
        self._final_metrics = np.moveaxis(self._by_env(core.final_metrics), -1, 0)
        self._ended = core.ended
        self._metric_names = core.metric_names
        self._metric_masks = {f"_{name}": self._everyone for name in core.metric_names}
        self._succeeded = np.zeros(self._done.shape, np.bool_)
        self._metric_views = {**dict(zip(self._metric_names, self._metrics, strict=True)), **self._metric_masks}
        self._success = self._metric_views.get("success")
        if self._success is not None:
            self._metric_views["success"] = self._succeeded

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode in every environment, or in those of `options["reset_mask"]`, (num_envs,) bool."""
        mask = None if options is None else options.get("reset_mask")
        if mask is not None:
            self._check_mask(mask)
        seeds = self._seeds(seed)
        super().reset(seed=seed if isinstance(seed, int) else None)
        self._batch.reset(seeds, options, mask)
        self._begun = True
        return self._copied(self._observations), self._infos()

    def step(self, actions: Any) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """One control step of every environment. Raises ContractError, and does nothing, for an action that is none.

        Args:
            actions: (num_envs, 3) in [-1, 1], of teams (num_envs, num_robots, 3): shares of the operating limits
                forward, left and counter-clockwise.

        Returns:
            observations, rewards (num_envs,) float64, terminated and truncated (num_envs,) bool, infos; of teams each
            has num_robots as its second length.
        """
        active = ~self._done if self._team else None
        self._core.step(as_actions(actions, (self.num_envs, *self._team, 3)))
        infos = self._infos()
        if active is not None:
            infos["active"], infos["_active"] = active, self._everyone
        if self._same_step and self._ended.any():
            self._add_final(infos)
        rewards, terminated, truncated = self._outcome
        if self._copy:
            return self._copied(self._observations), rewards.copy(), terminated.copy(), truncated.copy(), infos
        return self._observations, rewards, terminated, truncated, infos

    @property
    def spec(self) -> EnvSpec | None:
        """What the batch was made from, with `max_episode_steps`."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = with_limit(spec, self._batch.options["max_steps"])

    def episode(self, env: int) -> EpisodeInfo:
        """Which episode an environment is in: `reset(seed=[...], options={"episode_number": ...})` repeats it."""
        return self._core.episode(as_seed("env", env))

    @property
    def true_poses(self) -> NDArray[np.float64]:
        """x, y [m] and theta [rad] of every robot in its scene's frame, (num_envs * num_robots, 3). Privileged."""
        return self._core.true_poses

    def instruction(self, env: int) -> str:
        """What an environment's episode is about: the instruction of VLN, the `object_goal` of ObjectNav."""
        return self._core.instruction(as_seed("env", env))

    def randomization(self, env: int) -> dict[str, float]:
        """How an environment's robot differs from its profile now: the value of each knob."""
        return self._core.variation(as_seed("env", env))

    def _seeds(self, seed: int | list[int | None] | None) -> list[int | None]:
        if seed is None:
            if self._begun:
                return [None] * self.num_envs
            seed = int(self.np_random.integers(2**63))
        if isinstance(seed, int | np.integer):
            first = as_seed("seed", seed)
            return [as_seed("seed", first + i) for i in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ContractError(f"seed must be a number or a list of {self.num_envs}, got a list of {len(seed)}")
        return [None if one is None else as_seed("seed", one) for one in seed]

    def _check_mask(self, mask: Any) -> None:
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (self.num_envs,):
            raise ContractError(f"options['reset_mask'] must be a bool array of shape ({self.num_envs},), got {mask!r}")
        if not mask.any():
            raise ContractError("options['reset_mask'] must choose at least one environment")

    def _by_env(self, values: NDArray[Any]) -> NDArray[Any]:
        """A view of what there is for each robot."""
        return values.reshape(-1, *self._team, *values.shape[1:])

    def _copied(self, observations: Observation) -> Observation:
        return {name: values.copy() for name, values in observations.items()} if self._copy else observations

    def _infos(self) -> dict[str, Any]:
        if self._copy:
            return self._copied_infos(self._metrics)
        if self._success is not None:
            np.greater(self._success, 0.0, out=self._succeeded)
        return self._metric_views.copy()

    def _copied_infos(self, metrics: NDArray[np.float64]) -> dict[str, Any]:
        infos: dict[str, Any] = {**dict(zip(self._metric_names, metrics.copy(), strict=True)), **self._metric_masks}
        if "success" in infos:
            infos["success"] = infos["success"] > 0.0
        return infos

    def _add_final(self, infos: dict[str, Any]) -> None:
        ended = self._ended.copy()
        final = np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(ended):
            final[i] = {name: values[i].copy() for name, values in self._final_observations.items()}
        info = self._copied_infos(self._final_metrics)
        infos["final_obs"] = final
        infos["final_info"] = {name: ended if name.startswith("_") else values for name, values in info.items()}
        infos["_final_obs"] = infos["_final_info"] = ended
