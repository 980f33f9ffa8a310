"""One drive as a few figures and a hash of its trajectory: how it ended, when, and how far it came."""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

import numpy as np
from threewe import Robot, World, force_target
from threewe._core import DriveLog

TICK = 0.02  # [s]
Outcome = dict[str, Any]
"""`reason`, `success`, `seconds` [s] and `metres` [m] of a drive, and `hash`, of its trajectory to the bit."""


def outcome(reason: str, success: bool, seconds: float, metres: float, *hashed: bytes) -> Outcome:
    """Returns the outcome of one drive."""
    digest = hashlib.sha256(b"".join(hashed)).hexdigest()[:16]
    figures = {"seconds": round(seconds, 2), "metres": round(metres, 3)}
    return {"reason": reason, "success": bool(success), **figures, "hash": digest}


def of_logs(reason: str, success: bool, logs: list[DriveLog]) -> Outcome:
    """Returns the outcome of logged drives together, one after another."""
    steps = [np.diff(log.poses[:, :2], axis=0) for log in logs]
    metres = sum(float(np.hypot(*step.T).sum()) for step in steps)
    arrays = [array.tobytes() for log in logs for array in (log.poses, log.commands)]
    return outcome(reason, success, TICK * sum(map(len, logs)), metres, *arrays)


def of_case(
    function: Callable[..., dict[str, Any]], success: Callable[[dict[str, Any]], bool], **arguments: Any
) -> Outcome:
    """Returns the outcome of a case of `./dev verify` that makes robots in Python."""
    with logged() as logs:
        case = function(**arguments)
    return of_logs(str(case.get("reason", "")), success(case), logs)


def of_attempt(tried: dict[str, Any]) -> Outcome:
    """Returns the outcome of what the benchmark's `attempt` came to."""
    metrics = tried["metrics"]
    success = metrics["success"] if "success" in metrics else metrics["coverage"] >= 0.95
    everything = json.dumps([tried["trajectory"], tried["replayed"], metrics]).encode()
    return outcome(tried["failure"] or tried["end"], success, metrics["duration"], metrics["path_length"], everything)


@contextmanager
def logged() -> Iterator[list[DriveLog]]:
    """Logs the first robot of every world that is made meanwhile: true poses and commands, tick by tick."""
    logs: list[DriveLog] = []
    with ExitStack() as patches:
        for kind in (Robot, World):
            patches.enter_context(patch.object(kind, "__init__", logging_init(kind.__init__, logs)))
        yield logs


def logging_init(init: Callable[..., None], logs: list[DriveLog]) -> Callable[..., None]:
    """Returns a constructor that also logs the world that it makes."""

    def construct(self: Any, *arguments: Any, **options: Any) -> None:
        init(self, *arguments, **options)
        logs.append(DriveLog(self._world))

    return construct


def perform(function: Callable[..., Outcome], arguments: dict[str, Any], target: str) -> Outcome:
    """Drives one fixed episode on a vector target, on the fastest where it is empty."""
    logging.getLogger("threewe").setLevel(logging.ERROR)
    force_target(target)
    return function(**arguments)
