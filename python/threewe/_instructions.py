"""Instructions of one robot: the agent in C++, stepped between ticks."""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from threewe import _core
from threewe._arguments import as_seconds, as_text
from threewe._core import Agent, CameraIntrinsics, Detector
from threewe._execution_result import Exchange, ExecutedStep, ExecutionResult
from threewe._model_skills import BadCallError, Call, read_call, read_steps
from threewe._user_skills import UserSkills
from threewe.errors import ContractError, EmergencyStopError, SafetyError, TimeoutError
from threewe.language import read_command

if TYPE_CHECKING:
    from threewe.robot import Robot

MOST_STEPS = 30
NAMED = 0.5
"""Confidence from which a detection is said to be of its kind."""
LONGEST = 900.0
"""[s] of robot time that a skill may take a program."""
PERIOD = 0.1
"""[s] of robot time between two updates."""


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
        self.note(
            step.skill,
            step.text,
            step.arguments,
            step.reason,
            step.detail,
            (step.begun, step.ended),
            step.thing,
            step.verified,
        )

    def note(
        self,
        skill: str,
        text: str,
        arguments: Mapping[str, object],
        reason: str,
        detail: str,
        time: tuple[float, float] | None = None,
        thing: int = 0,
        verified: bool = False,
    ) -> None:
        """What was asked for; without a time it has not begun."""
        begun, ended = time or (self._robot.now, self._robot.now)
        camera = self._robot.profile.camera
        picture = np.empty((0, 0, 3), np.uint8) if camera is None else self._robot.get_image()
        seen = () if camera is None else self._seen(picture, camera.intrinsics)
        said = skill, text, dict(arguments), reason, detail
        self.steps.append(ExecutedStep(*said, begun, ended, thing, verified, picture, seen))

    def _seen(
        self, picture: NDArray[np.uint8], camera: CameraIntrinsics
    ) -> tuple[tuple[str, str, tuple[int, int, int, int]], ...]:
        detector = self._robot._instructed().detector
        found = detector.detect(picture, camera)
        labels, seen = detector.labels, []
        for one in found:
            if one.confidence >= NAMED:
                kind, (left, top, right, bottom) = labels[one.kind_index], one.box
                seen.append((kind, f"{one.color} {kind} {one.confidence:.0%}", (left, top, right, bottom)))
        return tuple(seen)


class Instructions:
    """Executes instructions, and remembers from one to the next what the robot has seen."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.detector = robot._detector or Detector.load()
        self.agent = Agent(robot._runtime, self.detector)
        self.skills = UserSkills()
        self.busy = False
        """while a model or a user's skill has an instruction"""
        self.busy_with_skill = False
        self.models: dict[str, tuple[str | None, bool | None]] = {}
        """how models by their address answer, and whether they see, where that is known"""

    async def execute(self, instruction: str, steps: int, duration: float) -> ExecutionResult:
        """See `Robot.execute_instruction`, without a model."""
        try:
            parts = self.skills.parts(as_text("instruction", instruction))
        except BadCallError as bad:
            return self.result(instruction, Run(self._robot), "not_understood", str(bad), "", False)
        if not any(isinstance(part, Call) for part in parts):
            return await self._execute_text(instruction, instruction, steps, duration)
        places = [place.name for place in self.agent.places]
        for part in parts:
            if isinstance(part, str) and not read_command(part, places).steps:
                return await self._execute_text(instruction, part, steps, duration)
        return await self._execute_parts(instruction, parts, steps, duration)

    async def _execute_text(self, name: str, text: str, steps: int, duration: float) -> ExecutionResult:
        """What the grammar reads, to its end; `name` is what was asked for."""
        self.begin(text, steps, duration)
        run = Run(self._robot)
        said = await self.finish(run)
        return self.result(name, run, said.reason, said.detail, said.answer, said.verified)

    async def _execute_parts(
        self, instruction: str, parts: list[str | Call], steps: int, duration: float
    ) -> ExecutionResult:
        """In order, to the first that fails."""
        self.check_options(steps, duration)
        run = Run(self._robot)
        reason, detail, answer, verified = "done", "", "", False
        for part in parts:
            left = run.begun + duration - self._robot.now
            if len(run.steps) >= steps or left <= 0.0:
                reason, detail = "budget", f"it took more than {steps} steps or {duration:g} s"
                break
            if isinstance(part, Call):
                reason, detail, new = await self.run_own(part, run, left)
                seen = False
            else:
                self.begin(part, steps - len(run.steps), left)
                result = await self.finish(run)
                reason, detail, new, seen = result.reason, result.detail, result.answer, result.verified
            answer, verified = (new, seen) if new else (answer, verified)
            if reason != "done":
                break
        return self.result(instruction, run, reason, detail, answer, verified)

    async def execute_skill(self, skill: object, arguments: dict[str, object]) -> ExecutionResult:
        """See `Robot.execute_skill`."""
        try:
            call = read_call(skill, arguments, self.skills.all)
            if call.skill == "done":
                raise BadCallError("skill: 'done' ends what a model does, and is none of programs")
            if call.skill in self.skills:
                return await self._execute_parts(str(call), [call], MOST_STEPS, LONGEST)
            text, count = read_steps(call, [place.name for place in self.agent.places], self.agent.labels[1:])
        except BadCallError as bad:
            raise ContractError(str(bad)) from None
        return await self._execute_text(str(call), text, count, LONGEST)

    async def run_own(self, call: Call, run: Run, limit: float) -> tuple[str, str, str]:
        """Executes a user's skill for at most `limit` [s] of robot time: reason, detail and answer.

        What it raises is the reason `skill_error`. It looks around meanwhile as the agent does.
        """
        if self._robot.emergency_stopped:
            raise EmergencyStopError("the emergency stop is latched")
        if self.busy_with_skill or not self.agent.done:
            raise SafetyError("an instruction is being executed: wait for it, or cancel it")
        begun, was_busy = self._robot.now, self.busy
        self.busy = self.busy_with_skill = True
        looking = asyncio.ensure_future(self._look(run))
        try:
            async with self._robot.timeout(limit):
                reason, detail, answer = await self.skills.run(call, self._robot)
        except TimeoutError:
            reason, detail, answer = "budget", f"{call.skill} took more than {limit:g} s", ""
        except EmergencyStopError:
            reason, detail, answer = "estop", "the emergency stop is latched", ""
        except Exception as error:
            logging.getLogger("threewe").exception("skill %s failed", call)
            reason, detail, answer = "skill_error", f"{call.skill}: {type(error).__name__}: {error}", ""
        finally:
            self.busy, self.busy_with_skill = was_busy, False
            looking.cancel()
            await asyncio.gather(looking, return_exceptions=True)
            self._robot.stop()  # whatever it has begun
        run.note(call.skill, str(call), call.arguments, reason, detail, (begun, self._robot.now))
        return reason, detail, answer

    async def _look(self, run: Run) -> None:
        while True:
            self.agent.update()
            await self._robot.sleep(PERIOD)
            run.way.append(self._robot.get_pose())

    def begin(self, instruction: str, steps: int, duration: float) -> None:
        """Reads an instruction; `finish` executes it."""
        self.check_options(steps, duration)
        self.agent.begin(as_text("instruction", instruction), steps, as_seconds("timeout", duration))

    def check_options(self, steps: int, duration: float) -> None:
        """Raises what is wrong with them, or with now."""
        as_seconds("timeout", duration)
        if isinstance(steps, bool) or not isinstance(steps, int) or steps < 1:
            raise ContractError(f"max_steps must be a whole number >= 1, got {steps!r}")
        if self.busy:
            raise SafetyError("an instruction is being executed: wait for it, or cancel it")

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
        conversation: tuple[Exchange, ...] = (),
    ) -> ExecutionResult:
        """What became of it."""
        camera = self._robot.profile.camera
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
            camera.intrinsics if camera else None,
            conversation,
        )
