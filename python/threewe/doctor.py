"""What is installed, what works, and what to do about the rest."""

from __future__ import annotations

import asyncio
import importlib.metadata
import platform
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import threewe
from threewe.testing import check_backend


@dataclass(frozen=True)
class Finding:
    """The state of one part."""

    part: str
    state: Literal["ok", "missing", "broken"]
    detail: str
    remedy: str = ""


def examine() -> list[Finding]:
    """Looks at every part once. Nothing is changed."""
    return [
        Finding("Python", "ok", f"{platform.python_version()} on {platform.machine()}"),
        Finding("threewe", "ok", f"{threewe.__version__}, vector target {threewe.active_target()}"),
        *_backends(),
        _works("simulated drive", _drive),
        _package("pillow", "pictures and films", "demo"),
        _package("av", "run.mp4", "demo"),
        _package("rerun-sdk", "threewe view", "viz"),
    ]


def _backends() -> list[Finding]:
    others = [name for name in threewe.backend_names() if name != "mock"]
    return [
        _works("backend mock", _contract),
        *(Finding(f"backend {name}", "ok", "found, not tried") for name in others),
    ]


def _contract() -> str:
    results = check_backend("mock", show=False, raise_failures=True)
    return f"keeps the contract: {len(results)} checks"


def _package(name: str, purpose: str, extra: str) -> Finding:
    try:
        return Finding(name, "ok", f"{importlib.metadata.version(name)}, for {purpose}")
    except importlib.metadata.PackageNotFoundError:
        return Finding(name, "missing", f"needed for {purpose}", f"{sys.executable} -m pip install 'threewe[{extra}]'")


def _works(part: str, check: Callable[[], str]) -> Finding:
    try:
        return Finding(part, "ok", check())
    except threewe.ThreeweError as error:
        return Finding(part, "broken", str(error), "install it again; if it stays, please report it")


def _drive() -> str:
    """Half a metre ahead in the default world."""

    async def drive() -> threewe.MoveResult:
        async with threewe.Robot(noise="ideal") as robot:
            return await robot.move_forward(0.5)

    result = asyncio.run(drive())
    result.raise_for_failure()
    return f"0.5 m in {result.duration:.1f} robot seconds"
