"""The native batch as Stable-Baselines3 takes it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Unpack

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from threewe._extras import needed_for
from threewe.errors import ContractError
from threewe.gym.batch import EnvOptions, Observation
from threewe.gym.vector import VectorEnv

with needed_for("SB3VecEnv", "train"):
    from stable_baselines3.common.vec_env import VecEnv

Indices = int | Iterable[int] | None


class SB3VecEnv(VecEnv):  # type: ignore[misc]
    """A `VecEnv` for Stable-Baselines3: all environments in one C++ batch, an episode's end begins the next one.

    `infos` tell something only where an episode ended: `terminal_observation`, `TimeLimit.truncated`, `is_success` and
    the task's metrics.

    Args:
        task: see `Env`.
        num_envs: how many.
        num_threads: that share the work.
        options: see `EnvOptions`.
    """

    def __init__(self, *, task: str, num_envs: int = 1, num_threads: int = 1, **options: Unpack[EnvOptions]) -> None:
        self._batch = VectorEnv(
            task=task,
            num_envs=num_envs,
            num_threads=num_threads,
            autoreset_mode=AutoresetMode.SAME_STEP,
            **options,
        )
        self._nothing: list[dict[str, Any]] = [{} for _ in range(num_envs)]
        super().__init__(num_envs, self._batch.single_observation_space, self._batch.single_action_space)

    def reset(self) -> Observation:
        """Begins an episode in every environment, with the seeds of `seed` and the options of `set_options`."""
        if any(options != self._options[0] for options in self._options):
            raise ContractError("set_options: all environments of the batch take the same options")
        unseeded = all(seed is None for seed in self._seeds)
        observations, _ = self._batch.reset(seed=None if unseeded else self._seeds, options=self._options[0] or None)
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Keeps the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Observation, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """One control step of every environment."""
        observations, rewards, terminated, truncated, infos = self._batch.step(self._actions)
        ended = terminated | truncated
        each = self._nothing
        if ended.any():
            each = list(each)
            final = infos["final_info"]
            names = [name for name in final if not name.startswith("_")]
            for i in np.flatnonzero(ended):
                each[i] = {
                    **{name: final[name][i].item() for name in names},
                    "terminal_observation": infos["final_obs"][i],
                    "TimeLimit.truncated": bool(truncated[i]),
                    "is_success": bool(final["success"][i]),
                }
        return observations, rewards.astype(np.float32), ended, each

    def close(self) -> None:
        """Ends the batch."""
        self._batch.close()

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """The batch's attribute, once for each environment."""
        value = getattr(self._batch, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, *_: Any, **__: Any) -> None:
        """Refused: the environments are one batch."""
        raise ContractError(f"set_attr({attr_name!r}): the environments are one batch, made as they are to be")

    def env_method(self, method_name: str, *_: Any, **__: Any) -> list[Any]:
        """Refused: the environments are one batch."""
        raise ContractError(
            f"env_method({method_name!r}): the environments are one batch, with methods for all of them"
        )

    def env_is_wrapped(self, wrapper_class: type, indices: Indices = None) -> list[bool]:  # noqa: ARG002
        """None of them is."""
        return [False for _ in self._get_indices(indices)]
