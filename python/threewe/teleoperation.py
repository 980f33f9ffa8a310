"""The command `threewe teleop`."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Annotated, Literal

import typer

import threewe
from threewe._console import plain_console
from threewe.driving import Backend, Hardware, Rerun, SceneName, Seed

console = plain_console()

DriveWith = Annotated[
    Literal["keyboard", "gamepad", "auto"], typer.Option("--input", help="Auto: a gamepad where one is plugged in.")
]
Device = Annotated[
    Path | None, typer.Option(metavar="PATH", help="The gamepad: /dev/input/event*; the first one by default.")
]
Speed = Annotated[int, typer.Option(min=1, max=9, help="At the start; 9 is the operating limit.")]
Latch = Annotated[
    bool, typer.Option("--latch", help="A key drives on when it is released: until the opposite key, or space.")
]


def teleop(
    backend: Backend = "mock",
    scene: SceneName = "office_v2",
    hardware: Hardware = "3we_standard_v2",
    seed: Seed = 0,
    drive_with: DriveWith = "auto",
    device: Device = None,
    speed: Speed = 5,
    latch: Latch = False,
    rerun: Rerun = False,
) -> None:
    """Drive a robot by keyboard or gamepad: it stops when you let go, and the safety gate stays in charge.

    Terminals do not report that a key was released: hold it down and the terminal repeats it. One press drives for
    0.7 s.
    """
    from threewe.teleop.session import drive_by_hand, run_until_ended

    robot = threewe.Robot(backend, hardware, scene, seed=seed, realtime=True, viewer="rerun" if rerun else None)
    title = f"{hardware} on {backend}, {scene}"
    with suppress(KeyboardInterrupt):  # Ctrl-C is one way to end
        run_until_ended(drive_by_hand(robot, console, title, drive_with, device, level=speed, latch=latch))
