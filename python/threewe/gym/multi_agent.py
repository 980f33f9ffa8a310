"""Several robots in one place, as PettingZoo has it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar, Unpack

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from threewe import _core
from threewe._arguments import as_seed
from threewe._extras import needed_for
from threewe.errors import ConfigError, ContractError
from threewe.gym.batch import EnvOptions, Observation, as_actions, make_batch
from threewe.gym.rendering import RENDER_MODES, make_onlooker

with needed_for("MultiAgentEnv", "marl"):
    from pettingzoo import ParallelEnv

T = TypeVar("T")
Infos = dict[str, dict[str, Any]]


class MultiAgentEnv(ParallelEnv[str, Observation, NDArray[np.float32]]):  # type: ignore[misc]
    """A task for a team: agents `robot_0`, `robot_1` ... that see and block one another.

    Observations, actions, rewards and infos are those of `Env`, for each agent. In `exploration` the robots share one
    coverage map, and each gets the reward of the team; in `navigation` each has a goal of its own. Poses are in a frame
    with its origin where `robot_0` started. Who has arrived or failed leaves `agents` and stands where it is, in the
    others' way.

    With the same seeds and actions, `VectorEnv(num_robots=...)` gives the same bits.

    Args:
        task: `exploration`, `navigation`.
        num_robots: 2 to 4.
        render_mode: see `Env`.
        options: see `EnvOptions`.
    """

    metadata: dict[str, Any] = {"name": "3we/MultiAgent-v1", "render_modes": RENDER_MODES, "render_fps": 10}  # noqa: RUF012

    def __init__(
        self,
        *,
        task: str = "exploration",
        num_robots: int = 2,
        render_mode: str | None = None,
        **options: Unpack[EnvOptions],
    ) -> None:
        if num_robots not in range(2, 5):
            raise ConfigError(f"num_robots must be 2, 3 or 4, got {num_robots!r}")
        self._batch = make_batch(
            task, num_envs=1, num_robots=num_robots, num_threads=1, autoreset="disabled", **options
        )
        self._core = self._batch.core
        self._begun = False
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": self._batch.options["control_rate"]}
        self._onlooker = make_onlooker(render_mode, self._batch)
        self.possible_agents = [f"robot_{i}" for i in range(num_robots)]
        self.agents: list[str] = []
        # each its own, so that they are seeded one by one
        space = self._batch.observation_space.spaces
        self.observation_spaces = {agent: spaces.Dict(space) for agent in self.possible_agents}
        self.action_spaces = {agent: spaces.Box(-1.0, 1.0, (3,), np.float32) for agent in self.possible_agents}

    def observation_space(self, agent: str) -> spaces.Dict:
        """The same object at each call."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Box:
        """The same object at each call."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], Infos]:
        """Begins an episode: the first of a seed, or the next one. Options as in `Env`, for `robot_0`."""
        given = None if seed is None else as_seed("seed", seed)
        if given is None and not self._begun:
            given = int(np.random.default_rng().integers(2**63))
        # PettingZoo's own test asks for an option of the name "options"
        known = {name: value for name, value in (options or {}).items() if name != "options"}
        self._batch.reset([given], known, None)
        self._begun = True
        if self._onlooker:
            self._onlooker.begin()
        self.agents = list(self.possible_agents)
        everyone = range(len(self.agents))
        return self._named(everyone, self._batch.observation), self._named(everyone, self._batch.first_info)

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], Infos]:
        """One control step of all `agents`, each with its action. Raises ContractError, and does nothing, otherwise.

        Args:
            actions: by the agents' names, each (3,) in [-1, 1]: shares of the operating limits forward, left and
                counter-clockwise.

        Returns:
            observations, rewards, terminated, truncated and infos, each by the agents' names.
        """
        stepped = [i for i, agent in enumerate(self.possible_agents) if agent in self.agents]
        self._core.step(self._as_actions(actions))
        if self._onlooker:
            self._onlooker.look()
        self.agents = [self.possible_agents[i] for i in stepped if not self._core.done[i]]
        return (
            self._named(stepped, self._batch.observation),
            self._named(stepped, lambda i: float(self._core.rewards[i])),
            self._named(stepped, lambda i: bool(self._core.terminated[i])),
            self._named(stepped, lambda i: bool(self._core.truncated[i])),
            self._named(stepped, self._batch.info),
        )

    def render(self) -> Any:
        """See `Env`."""
        return self._onlooker.render() if self._onlooker else None

    def close(self) -> None:
        """Ends what `render_mode` began."""
        if self._onlooker:
            self._onlooker.close()

    def _as_actions(self, actions: dict[str, Any]) -> NDArray[np.float32]:
        for name in actions:
            if name not in self.agents:
                raise ContractError(_core.unknown_name("agent", str(name), self.agents))
        values = np.zeros((len(self.possible_agents), 3), np.float32)
        for i, agent in enumerate(self.possible_agents):
            if agent not in self.agents:
                continue
            if agent not in actions:
                raise ContractError(f"actions: {agent} has none")
            values[i] = as_actions(actions[agent], (3,))[0]
        return values

    def _named(self, robots: Iterable[int], of: Callable[[int], T]) -> dict[str, T]:
        return {self.possible_agents[i]: of(i) for i in robots}
