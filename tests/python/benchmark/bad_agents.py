"""Agents that fail, each in its own way."""

from __future__ import annotations

import asyncio
import math
import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np


class Raises:
    async def run(self, robot: Any, assignment: Any) -> None:
        await robot.move_forward(0.2)
        raise ValueError(f"no way to {assignment.goal}")


class RaisesFarAway:
    async def run(self, robot: Any, assignment: Any) -> None:
        if math.hypot(*assignment.goal) > 5.0:
            await robot.move_forward(0.2)
            raise ValueError("too far for me")
        await robot.move_to(*assignment.goal)


class IsKilledOnce:
    """Its process is, 0.2 m after the start, at the first attempt of each episode."""

    async def run(self, robot: Any, assignment: Any) -> None:
        await robot.move_forward(0.2)
        mark = Path(f"killed {assignment.seed}")
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        await robot.move_to(*assignment.goal)


class GivesUp:
    async def run(self, robot: Any, assignment: Any) -> None:
        async with robot.timeout(0.5):
            await robot.move_to(*assignment.goal)


class ClearsTheScreen:
    async def run(self, robot: Any, assignment: Any) -> None:
        await robot.move_to(*assignment.goal, timeout=0.5)
        raise ValueError("\x1b[2Jgone")


class PeeksAtTheTruth:
    async def run(self, robot: Any, assignment: Any) -> None:
        del assignment
        robot.simulation.true_pose()


class WaitsForTheWall:
    async def run(self, robot: Any, assignment: Any) -> None:
        del assignment
        await asyncio.wait_for(robot.sleep(1000.0), 1000.0)


class NotANumber:
    def act(self, observation: Any) -> Any:
        del observation
        return np.full(3, np.nan, np.float32)


class WrongShape:
    def act(self, observation: Any) -> Any:
        del observation
        return np.zeros(2, np.float32)


class Hangs:
    def act(self, observation: Any) -> Any:
        del observation
        time.sleep(1000.0)


class EatsMemory:
    def act(self, observation: Any) -> Any:
        del observation
        return bytearray(16 << 30)


class Dies:
    def act(self, observation: Any) -> Any:
        del observation
        os._exit(7)


class StandsStill:
    def act(self, observation: Any) -> Any:
        assert sorted(observation) == ["goal", "lidar", "pose", "velocity"]
        return np.zeros(3, np.float32)


class DoesNothing:
    pass


class NoCoroutine:
    def run(self, robot: Any, assignment: Any) -> None: ...


class WantsTheTruth:
    options = {"localization": "truth"}  # noqa: RUF012

    def act(self, observation: Any) -> Any: ...


class CannotBeMade:
    def __init__(self) -> None:
        raise ValueError("no weights")

    def act(self, observation: Any) -> Any: ...
