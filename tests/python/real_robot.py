"""The stand-in for a robot that speaks ROS 2: another process, on another DDS."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/dev/tests/ros2/ros2_robot"

# Networks of its own for each worker that runs tests, out of the way of the domain that people use.
WORKER = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
FIRST_DOMAIN = 4 * (1 + (os.getppid() + WORKER) % 24)
SILENT_DOMAIN = FIRST_DOMAIN + 3


class RealRobot:
    """One that runs inside `with`; afterwards `truth` is what it said of itself in the end."""

    def __init__(self, domain: int, *options: str) -> None:
        self.domain = domain
        self.options = options
        self.truth: dict[str, Any] = {}

    def __enter__(self) -> RealRobot:
        command = [str(PROGRAM), str(self.domain), *self.options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"
        return self

    def __exit__(self, *exception: object) -> None:
        self.process.terminate()
        output, _ = self.process.communicate(timeout=30)
        self.truth = json.loads(output)
