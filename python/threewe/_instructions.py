"""Instructions of one robot: the agent in C++, stepped between ticks."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from threewe import _core
from threewe._arguments import as_file, as_seconds, as_text
from threewe._core import Agent, CameraIntrinsics, Detector, MappedThing, OccupancyGrid, Place, Pose2D
from threewe._extras import needed_for
from threewe.errors import ContractError

if TYPE_CHECKING:
    from threewe.robot import Robot

PERIOD = 0.1
"""[s] of robot time between two updates."""


@dataclass(frozen=True)
class ExecutedStep:
    """One skill that was executed."""

    skill: str
    """such as `search`"""
    text: str
    """with its arguments: `search(kind=chair, color=red)`"""
    reason: str
    """how it ended: `done`, `not_found`, or a motion's reason"""
    detail: str
    """says more; may be empty"""
    begun: float
    """[s] of robot time"""
    ended: float
    """[s] of robot time"""
    thing: int
    """id of the mapped thing that it rests on; 0: none"""
    picture: NDArray[np.uint8] = field(repr=False, compare=False)
    """(H, W, 3) BGR, what the camera showed as it ended"""


@dataclass(frozen=True)
class ExecutionResult:
    """What became of an instruction."""

    instruction: str
    success: bool
    """`reason` is `done`"""
    reason: str
    """done, not_found, not_understood, ambiguous, refused, budget, or a motion's reason"""
    detail: str
    """says more about a failure; may be empty"""
    answer: str
    """to a question, or what was found, as a sentence; may be empty"""
    verified: bool
    """the robot's own detector saw what the answer says"""
    steps: tuple[ExecutedStep, ...]
    """the skills that were executed"""
    distance: float
    """[m] driven, by its own estimate"""
    duration: float
    """[s] of robot time"""
    way: tuple[Pose2D, ...] = field(repr=False)
    """where it was by its own estimate, in `map`, each 0.1 s"""
    map: OccupancyGrid = field(repr=False)
    """its own, at the end"""
    things: tuple[MappedThing, ...] = field(repr=False)
    """that it knew of, at the end"""
    places: tuple[Place, ...] = field(repr=False)
    """that had names"""
    labels: tuple[str, ...] = field(repr=False)
    """what the kinds of things are called"""
    camera: CameraIntrinsics = field(repr=False)
    """of the pictures"""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a page, one HTML file: map, way, things, and each step with its picture. Needs the extra `demo`.

        Raises:
            ContractError: a path that does not end in .html.
            ConfigError: it cannot be written.
        """
        with needed_for("a report", "demo"):
            from threewe._instruction_report import write_report

        write_report(self, as_file("path", path))


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
        way = [self._robot.get_pose()]
        ended: list[ExecutedStep] = []
        try:
            while not self.agent.done:
                self.agent.update()
                ended += [self._with_picture(step) for step in self.agent.steps[len(ended) :] if step.reason]
                if not self.agent.done:
                    await self._robot.sleep(PERIOD)
                    way.append(self._robot.get_pose())
        finally:
            self.agent.cancel()  # does nothing once done
        result = self.agent.result
        assert self._robot.profile.camera is not None
        return ExecutionResult(
            instruction,
            result.success,
            result.reason,
            result.detail,
            result.answer,
            result.verified,
            (*ended, *(self._with_picture(step) for step in result.steps[len(ended) :])),
            result.distance,
            result.duration,
            tuple(way),
            self._robot.get_map(),
            tuple(self.agent.things),
            tuple(self.agent.places),
            tuple(self.agent.labels),
            self._robot.profile.camera.intrinsics,
        )

    def _with_picture(self, step: _core.ExecutedStep) -> ExecutedStep:
        said = (step.skill, step.text, step.reason, step.detail, step.begun, step.ended, step.thing)
        return ExecutedStep(*said, self._robot.get_image())
