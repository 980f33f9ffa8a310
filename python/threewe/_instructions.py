"""Instructions of one robot: the agent in C++, stepped between ticks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from threewe._arguments import as_seconds, as_text
from threewe._core import Agent, Detector, ExecutionResult
from threewe.errors import ContractError

if TYPE_CHECKING:
    from threewe.robot import Robot

PERIOD = 0.1
"""[s] of robot time between two updates."""


class Instructions:
    """Executes instructions, and remembers from one to the next what the robot has seen."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.agent = Agent(robot._runtime, Detector.load())

    async def execute(self, instruction: str, steps: int, duration: float) -> ExecutionResult:
        """See `Robot.execute_instruction`."""
        if isinstance(steps, bool) or not isinstance(steps, int) or steps < 1:
            raise ContractError(f"max_steps must be a whole number >= 1, got {steps!r}")
        self.agent.begin(as_text("instruction", instruction), steps, as_seconds("timeout", duration))
        try:
            while not self.agent.done:
                self.agent.update()
                if not self.agent.done:
                    await self._robot.sleep(PERIOD)
        finally:
            self.agent.cancel()  # does nothing once done
        return self.agent.result
