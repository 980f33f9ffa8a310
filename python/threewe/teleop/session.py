"""What commands need around `teleoperate`: input devices, the screen with its keys, and an orderly end by signals."""

from __future__ import annotations

import asyncio
import signal
import sys
from collections.abc import Coroutine
from contextlib import closing
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypeVar

from rich.console import Console

from threewe._core import Kinematics, RobotProfile
from threewe.errors import ConfigError
from threewe.robot import Robot
from threewe.teleop.events import CombinedInput, TeleopInput
from threewe.teleop.gamepad import GamepadInput, find_gamepads
from threewe.teleop.keyboard import KeyboardInput
from threewe.teleop.loop import Autonomy, EpisodeRecorder, Policy, teleoperate
from threewe.teleop.screen import TeleopScreen

Result = TypeVar("Result")
InputKind: TypeAlias = Literal["keyboard", "gamepad", "auto"]
"""What a person drives with."""


async def drive_by_hand(
    robot: Robot,
    console: Console,
    title: str,
    kind: InputKind = "auto",
    device: Path | None = None,
    *,
    level: int = 5,
    latch: bool = False,
    recorder: EpisodeRecorder | None = None,
    policy: Policy | None = None,
    autonomy: Autonomy | None = None,
    task: str = "teleoperation",
) -> int:
    """Connects the robot, and lets a person drive it, with the live status on a console, until the person ends it.

    Args:
        robot: not connected yet.
        console: where the status is shown.
        title: which robot is driven where, in one line.
        kind: see `open_input`, as are `device` and `latch`.
        level: see `teleoperate`, as are `recorder`, `policy`, `autonomy` and `task`.

    Returns:
        How many episodes were kept.
    """
    hands_over = policy is not None or autonomy is not None
    with closing(open_input(kind, device, latch=latch)) as source:
        async with robot:
            episodes = recorder is not None
            keys = key_lines(robot.profile, gamepad=source.has(GamepadInput), episodes=episodes, hands_over=hands_over)
            with TeleopScreen(robot, console, title, keys, episodes=episodes, hands_over=hands_over) as screen:
                return await teleoperate(
                    robot,
                    source,
                    recorder=recorder,
                    policy=policy,
                    autonomy=autonomy,
                    task=task,
                    level=level,
                    on_status=screen,
                )


def open_input(kind: InputKind, device: Path | None = None, *, latch: bool = False) -> CombinedInput:
    """The input devices of a command. The terminal's keyboard is always one of them where there is a terminal.

    Args:
        kind: `auto` takes a gamepad where one is plugged in; `gamepad` insists on one.
        device: the gamepad's, /dev/input/event*; the first one where left out.
        latch: see `KeyboardInput`.

    Raises:
        ConfigError: there is no gamepad or no terminal.
    """
    if device is not None and kind == "keyboard":
        raise ConfigError("--device names a gamepad, but --input is keyboard")
    sources: list[TeleopInput] = []
    if kind == "gamepad" or device is not None or (kind == "auto" and find_gamepads()):
        sources.append(GamepadInput(device))
    if sys.stdin.isatty():
        sources.append(KeyboardInput(sys.stdin.fileno(), latch=latch))
    elif not sources:
        raise ConfigError("the keyboard drives only in a terminal: run it in one, or use --input gamepad")
    return CombinedInput(sources)


def key_lines(profile: RobotProfile, *, gamepad: bool, episodes: bool = False, hands_over: bool = False) -> list[str]:
    """What keys and buttons do, for the screen."""
    holonomic = profile.kinematics is not Kinematics.differential
    sides = "A D left, right   Q E turn" if holonomic else "A D or Q E turn"
    lines = [f"W S ahead, back   {sides}   1..9 + - speed", "Space stop   X emergency stop, release   Esc end"]
    if hands_over:
        lines.append("any drive key takes over   T hands back to the policy")
    if episodes:
        lines.append("R start episode   Enter success   F failure   Backspace discard")
    if gamepad:
        lines.append("gamepad: left stick drives, right stick turns, cross up/down speed, A stop, B emergency stop")
        if episodes:
            lines.append("  start: start episode, right stick pressed: success, select: failure, Y: discard")
        if hands_over:
            lines.append("  X: hands back")
    return lines


def run_until_ended(main: Coroutine[Any, Any, Result]) -> Result:
    """Runs a coroutine and returns its result.

    SIGTERM and a closed terminal cancel it, so that the robot stops and the terminal is restored; then it raises
    SystemExit with 128 + the signal's number.
    """
    ended_by: list[int] = []

    async def run() -> Result:
        loop, task = asyncio.get_running_loop(), asyncio.current_task()
        assert task is not None

        def end(number: int) -> None:
            ended_by.append(number)
            task.cancel()

        for number in (signal.SIGTERM, signal.SIGHUP):
            loop.add_signal_handler(number, end, number)
        return await main

    try:
        return asyncio.run(run())
    except asyncio.CancelledError:
        if not ended_by:
            raise
        raise SystemExit(128 + ended_by[0]) from None
