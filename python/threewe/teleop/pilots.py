"""What drives a robot while no person does, as a task that can be stopped and started again."""

from __future__ import annotations

import asyncio
import inspect
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from threewe._arguments import as_array
from threewe._core import Velocity
from threewe.errors import ContractError
from threewe.robot import Robot

ACTION_LASTS = 0.5
"""[s] of robot time that an action outlasts its period where the next one is late; then the robot stops."""
SHORTEST_PERIOD = 0.02
"""[s] of robot time: one tick."""


class Pilot(ABC):
    """A task that drives. What it raises comes out of `velocity` and `stop`."""

    def __init__(self) -> None:
        self._task: asyncio.Task[object] | None = None

    def start(self) -> None:
        """Begins, unless it has begun."""
        if self._task is None:
            self._task = asyncio.ensure_future(self._run())

    async def stop(self) -> None:
        """Returns when the task is over."""
        task, self._task = self._task, None
        if task is None:
            return
        task.cancel()
        await asyncio.wait([task])
        if not task.cancelled():
            task.result()

    @property
    def finished(self) -> bool:
        """True when it has ended by itself. Raises what it raised."""
        if self._task is None or not self._task.done():
            return False
        self._task.result()
        return True

    @abstractmethod
    def velocity(self) -> Velocity | None:
        """What to ask for in the next tick; None where the task commands the robot itself."""

    @abstractmethod
    async def _run(self) -> object: ...


class PolicyPilot(Pilot):
    """A policy: an async function from observation to action.

    Args:
        robot: connected.
        policy: gets `robot.get_observation()`, gives (3,) in [-1, 1] of the operating limits.
        period: [s] of robot time between two calls.
    """

    def __init__(self, robot: Robot, policy: Callable[[Any], Awaitable[ArrayLike]], period: float) -> None:
        super().__init__()
        self._robot, self._policy, self._period = robot, policy, period
        self._velocity = Velocity()
        self._until = 0.0

    def velocity(self) -> Velocity:
        """The newest action, as a velocity; zero where it is too old."""
        return self._velocity if self._robot.now < self._until else Velocity()

    async def _run(self) -> None:
        self._until = 0.0
        limits = self._robot.profile.operating_limits
        while True:
            due = self._robot.now + self._period
            answer = self._policy(self._robot.get_observation())
            if not inspect.isawaitable(answer):
                raise ContractError(f"policy must be an async function; it returned {type(answer).__name__}")
            action = as_array("the policy's action", await answer, (3,))
            ahead, left, turn = np.clip(action, -1.0, 1.0).tolist()
            self._velocity = Velocity(ahead * limits.linear, left * limits.linear, turn * limits.angular)
            self._until = self._robot.now + self._period + ACTION_LASTS
            await self._robot.sleep(max(due - self._robot.now, SHORTEST_PERIOD))


class AutonomyPilot(Pilot):
    """Something that drives the robot itself, by motions or velocities, and may end.

    Args:
        begin: an async function without arguments; called anew whenever the robot is handed back.
    """

    def __init__(self, begin: Callable[[], Awaitable[object]]) -> None:
        super().__init__()
        self._begin = begin

    def velocity(self) -> None:
        """Never one: it commands the robot itself."""

    async def _run(self) -> object:
        return await self._begin()
