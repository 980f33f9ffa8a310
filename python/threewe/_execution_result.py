"""What became of an instruction, step by step."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from threewe._arguments import as_file
from threewe._core import CameraIntrinsics, MappedThing, OccupancyGrid, Place, Pose2D
from threewe._extras import needed_for


@dataclass(frozen=True)
class ExecutedStep:
    """One skill that was executed."""

    skill: str
    """such as `search`"""
    text: str
    """with its arguments: `search(kind=chair, color=red)`"""
    arguments: Mapping[str, object] = field(hash=False)
    """those that were said: [m], [rad] or [s] where they are numbers; of a skill of yours as they were given"""
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
    verified: bool
    """the robot's own detector saw what it says"""
    picture: NDArray[np.uint8] = field(repr=False, compare=False)
    """(H, W, 3) BGR, what the camera showed as it ended; without a camera (0, 0, 3)"""
    seen: tuple[tuple[str, str, tuple[int, int, int, int]], ...] = field(repr=False, compare=False)
    """kind, a description and the box [px] of each thing that the detector named in it, the largest first"""


@dataclass(frozen=True)
class Exchange:
    """One question to a model, and what came back."""

    time: float
    """[s] of robot time, when it was asked"""
    seconds: float
    """[s] of robot time that it took"""
    question: str = field(repr=False)
    """the text that was sent"""
    pictures: tuple[bytes, ...] = field(repr=False)
    """JPEG or PNG, that were sent with it"""
    answer: str
    """what the model said: a text, or calls as `rotate({"degrees": 90})`, one a line; or what went wrong"""
    failed: bool
    """there was no answer: the model or its server failed"""
    tokens: int
    """that it used"""


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
    camera: CameraIntrinsics | None = field(repr=False)
    """of the pictures; None without a camera"""
    conversation: tuple[Exchange, ...] = field(repr=False)
    """with a model, if there was one, in order"""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a page, one HTML file. Needs the extra `demo`.

        It shows map, way and things, each step with its picture, and what was said to and by a model.

        Raises:
            ContractError: a path that does not end in .html.
            ConfigError: it cannot be written.
        """
        with needed_for("a report", "demo"):
            from threewe._instruction_report import write_report

        write_report(self, as_file("path", path))
