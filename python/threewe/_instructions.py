"""Instructions of one robot: the agent in C++, stepped between ticks."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from threewe import _core
from threewe._arguments import as_file, as_seconds, as_text
from threewe._core import Agent, CameraIntrinsics, Detector, MappedThing, OccupancyGrid, Place, Pose2D
from threewe._extras import needed_for
from threewe.errors import ContractError, SafetyError

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
    """done, not_found, not_understood, ambiguous, refused, budget, model_error, or a motion's reason"""
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
    thinking: float
    """[s] of it while a model thought"""
    tokens: int
    """that a model used"""
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


class Run:
    """What became of an instruction so far."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.begun = robot.now
        self.way = [robot.get_pose()]
        self.steps: list[ExecutedStep] = []

    @property
    def distance(self) -> float:
        """[m] along the way, by the robot's own estimate."""
        return sum(math.dist((a.x, a.y), (b.x, b.y)) for a, b in pairwise(self.way))

    def add(self, step: _core.ExecutedStep) -> None:
        """A step that has ended, with the picture of now."""
        said = (step.skill, step.text, step.reason, step.detail, step.begun, step.ended, step.thing)
        self.steps.append(ExecutedStep(*said, self._robot.get_image()))

    def note(self, skill: str, text: str, reason: str, detail: str) -> None:
        """What was asked for and not begun."""
        now = self._robot.now
        self.steps.append(ExecutedStep(skill, text, reason, detail, now, now, 0, self._robot.get_image()))


class Instructions:
    """Executes instructions, and remembers from one to the next what the robot has seen."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.agent = Agent(robot._runtime, Detector.load())
        self.busy = False
        """while a model has an instruction"""
        self.models: dict[str, tuple[str | None, bool | None]] = {}
        """how models by their address answer, and whether they see, where that is known"""

    async def execute(self, instruction: str, steps: int, duration: float) -> ExecutionResult:
        """See `Robot.execute_instruction`, without a model."""
        self.begin(instruction, steps, duration)
        run = Run(self._robot)
        said = await self.finish(run)
        return self.result(instruction, run, said.reason, said.detail, said.answer, said.verified)

    def begin(self, instruction: str, steps: int, duration: float) -> None:
        """Reads an instruction; `finish` executes it."""
        if isinstance(steps, bool) or not isinstance(steps, int) or steps < 1:
            raise ContractError(f"max_steps must be a whole number >= 1, got {steps!r}")
        if self.busy:
            raise SafetyError("an instruction is being executed: wait for it, or cancel it")
        self.agent.begin(as_text("instruction", instruction), steps, as_seconds("timeout", duration))

    async def finish(self, run: Run) -> _core.ExecutionResult:
        """Executes what was begun, to its end."""
        ended = 0
        try:
            while not self.agent.done:
                self.agent.update()
                for step in self.agent.steps[ended:]:
                    if step.reason:
                        run.add(step)
                        ended += 1
                if not self.agent.done:
                    await self._robot.sleep(PERIOD)
                    run.way.append(self._robot.get_pose())
        finally:
            self.agent.cancel()  # does nothing once done
        result = self.agent.result
        for step in result.steps[ended:]:
            run.add(step)
        return result

    def result(
        self,
        instruction: str,
        run: Run,
        reason: str,
        detail: str,
        answer: str,
        verified: bool,
        thinking: float = 0.0,
        tokens: int = 0,
    ) -> ExecutionResult:
        """What became of it."""
        assert self._robot.profile.camera is not None
        return ExecutionResult(
            instruction,
            reason == "done",
            reason,
            detail,
            answer,
            verified,
            tuple(run.steps),
            run.distance,
            self._robot.now - run.begun,
            thinking,
            tokens,
            tuple(run.way),
            self._robot.get_map(),
            tuple(self.agent.things),
            tuple(self.agent.places),
            tuple(self.agent.labels),
            self._robot.profile.camera.intrinsics,
        )
