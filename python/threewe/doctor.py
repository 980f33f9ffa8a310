"""What is installed, what works, and what to do about the rest."""

from __future__ import annotations

import asyncio
import importlib.metadata
import platform
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

import threewe
from threewe.testing import check_backend

INSTALL_AGAIN = "install it again; if it stays, please report it"


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
        *_assets(),
        *_backends(),
        _works("simulated drive", _drive),
        _package("pillow", "pictures and films", "demo"),
        _package("av", "run.mp4", "demo"),
        _package("rerun-sdk", "threewe view", "viz"),
        _package("rosbags", "rosbag2 in threewe slam replay", "logs"),
    ]


def _assets() -> list[Finding]:
    """A finding for each folder: every scene and every robot in it is read."""
    try:
        directories = threewe.asset_directories()
    except threewe.ConfigError as error:
        return [Finding("assets", "broken", str(error), "correct THREEWE_PATH")]
    remedies = [INSTALL_AGAIN] + ["correct that file"] * (len(directories) - 1)
    return [
        _works(f"assets in {directory}", partial(_read, directory), remedy)
        for directory, remedy in zip(directories, remedies, strict=True)
    ]


def _read(directory: Path) -> str:
    scenes = [threewe.Scene.load(name) for name in threewe.scene_names() if _has(directory / "scenes", name)]
    robots = [threewe.RobotProfile.load(name) for name in threewe.profile_names() if _has(directory / "robots", name)]
    return f"{len(scenes)} scenes, {len(robots)} robots"


def _has(folder: Path, name: str) -> bool:
    return (folder / f"{name}.yaml").is_file()


def _backends() -> list[Finding]:
    others = [name for name in threewe.backend_names() if name not in ("mock", "mujoco", "real", "gazebo")]
    return [
        _works("backend mock", _contract),
        *_mujoco(),
        _finds("real", "Cyclone DDS is there; no robot was looked for"),
        _finds("gazebo", "ZeroMQ is there; no Gazebo was looked for"),
        *(Finding(f"backend {name}", "ok", "found, not tried") for name in others),
    ]


def _mujoco() -> list[Finding]:
    try:
        simulation = threewe.Robot(backend="mujoco").simulation
    except threewe.ConfigError as error:
        remedy = f"{sys.executable} -m pip install 'threewe[mujoco]'"
        return [Finding("backend mujoco", "missing", str(error).splitlines()[0], remedy)]
    stands = Finding("backend mujoco", "ok", "a robot stands in its world")
    try:
        if simulation:
            simulation.look()
    except threewe.HardwareError as error:
        what, remedy = str(error).split("\n", 1)
        return [stands, Finding("cameras on mujoco", "missing", what, remedy)]
    return [stands, Finding("cameras on mujoco", "ok", "its renderer draws")]


def _finds(backend: str, ok: str) -> Finding:
    try:
        threewe.Robot(backend=backend)
    except threewe.ConfigError as error:
        what, *remedies = str(error).splitlines()
        return Finding(f"backend {backend}", "missing", what, "".join(remedies))
    return Finding(f"backend {backend}", "ok", ok)


def _contract() -> str:
    results = check_backend("mock", show=False, raise_failures=True)
    return f"keeps the contract: {len(results)} checks"


def _package(name: str, purpose: str, extra: str) -> Finding:
    try:
        return Finding(name, "ok", f"{importlib.metadata.version(name)}, for {purpose}")
    except importlib.metadata.PackageNotFoundError:
        return Finding(name, "missing", f"needed for {purpose}", f"{sys.executable} -m pip install 'threewe[{extra}]'")


def _works(part: str, check: Callable[[], str], remedy: str = INSTALL_AGAIN) -> Finding:
    try:
        return Finding(part, "ok", check())
    except threewe.ThreeweError as error:
        return Finding(part, "broken", str(error), remedy)


def _drive() -> str:
    """Half a metre ahead in the default world."""

    async def drive() -> threewe.MoveResult:
        async with threewe.Robot(noise="ideal") as robot:
            return await robot.move_forward(0.5)

    result = asyncio.run(drive())
    result.raise_for_failure()
    return f"0.5 m in {result.duration:.1f} robot seconds"
