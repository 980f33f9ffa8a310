"""Agent of benchmarks: a learned policy is given the name of a kind, and drives to it."""

from __future__ import annotations

import hashlib
import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from threewe.ai.runner import VLARunner
from threewe.errors import NavigationError, TimeoutError
from threewe.robot import Robot

if TYPE_CHECKING:
    from threewe.benchmark.tasks import Assignment

LIMIT = 60.0
"""[s] that a policy is given"""


class PolicyAgent:
    """Drives as `VLARunner.run` does, instructed to "go to the KIND"; where the policy stands still, it says STOP.

    Args:
        folder: of the policy, or the name of one that is shipped.
        instruction: in place of that of the task.
        latency: [s] in place of the policy's own.
    """

    def __init__(self, folder: str | os.PathLike[str], instruction: str = "", latency: float | None = None) -> None:
        self._runner = VLARunner.from_pretrained(folder)
        policy = self._runner.policy
        self.content = b"".join(hashlib.sha256(file.read_bytes()).digest() for file in policy.files())
        if latency is not None:
            self._runner.policy = replace(policy, latency=latency)
        camera = policy.cameras[0]
        self.options: dict[str, Any] = {"image_size": (camera.height, camera.width)}
        self._instruction = instruction

    async def run(self, robot: Robot, assignment: Assignment) -> None:
        """Returns where the policy says that it is there."""
        instruction = self._instruction or f"go to the {assignment.category}"
        result = await self._runner.run(
            robot, instruction if self._runner.policy.language else "", timeout=min(LIMIT, assignment.time_limit)
        )
        if result.reason == "timeout":
            raise TimeoutError(result.detail)
        if not result.success:
            raise NavigationError(f"{result.reason}: {result.detail}")
