"""The stand-in for a robot that speaks ROS 2: another process, on another DDS."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/dev/tests/ros2/ros2_robot"
NAV2 = ROOT / "build/dev/tests/ros2/ros2_nav2"

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


class Nav2:
    """One that localises and drives a `RealRobot` of the domain with the option `--truth`; see tests/ros2/nav2.cpp.

    Afterwards `asked` is what it was asked for.
    """

    def __init__(self, domain: int, *options: str) -> None:
        self.command = [str(NAV2), str(domain), *options]
        self.asked: dict[str, int] = {}

    def __enter__(self) -> Nav2:
        self.process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self.line() == "ready"
        return self

    def line(self) -> str:
        """The next line that it prints."""
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()

    def set(self, mode: str) -> None:
        """How it treats goals from now on."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{mode}\n")
        self.process.stdin.flush()

    def __exit__(self, *exception: object) -> None:
        output, _ = self.process.communicate(timeout=30)
        if output.strip():
            self.asked = json.loads(output.splitlines()[-1])
