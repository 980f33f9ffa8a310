"""The embedded simulator fitted to another robot: a simulated one, or yours."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from threewe import _core
from threewe._arguments import as_file, as_text
from threewe._console import plain_console, styled
from threewe._core import Calibration, Deviation, Figure
from threewe.backend import known_backend
from threewe.errors import ConfigError

__all__ = ["Calibration", "Deviation", "Figure", "calibrate"]


def calibrate(
    backend: str, hardware: str = "3we_standard_v2", *, output: str | os.PathLike[str] | None = None
) -> Calibration:
    """Fits what the embedded simulator knows of a robot's drive to how the robot moves on a backend.

    Drives steps, ramps, circles, strafes, spins and medleys of them, each there and back again, and where the robot
    can be put somewhere, pushes against a wall. The robot needs 2 m of free floor around it, and a person who watches
    it when it is a real one. A simulator tells the truth about its body's velocity; of other robots, wheel odometry and
    gyro do.

    Args:
        backend: its name.
        hardware: the profile of the robot, its name or a file that ends in .yaml.
        output: a file for the fitted profile, which `hardware=` takes then.

    Raises:
        ConfigError: an unknown backend or profile, or an output that does not end in .yaml.
    """
    path = None if output is None else as_file("output", output)
    if path is not None and path.suffix != ".yaml":
        raise ConfigError(f"output: the name of a profile's file ends in .yaml, not '{path.suffix}'")
    name = as_text("hardware", hardware)
    found = _core.calibrate(known_backend(as_text("backend", backend)), name)
    if path is not None:
        path.write_text(_core.calibrated_yaml(name, found), encoding="utf-8")
    return found


def command(
    backend: Annotated[str, typer.Option(help="Where the robot is.")],
    hardware: Annotated[
        str, typer.Option(help="Which robot: a name, or a file that ends in .yaml.")
    ] = "3we_standard_v2",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The fitted profile; HARDWARE_BACKEND.yaml by default.")
    ] = None,
) -> None:
    """Fit the embedded simulator's motors and wheels to a robot, and write its profile."""
    path = output or Path(f"{Path(hardware).stem}_{backend}.yaml")
    console = plain_console()
    with console.status("driving"):
        found = calibrate(backend, hardware, output=path)
    table = Table("figure", "profile", "fitted", "95 %", title=f"{hardware} on {backend}, by its {found.source}")
    for figure in found.figures:
        remark = "" if figure.identifiable else "  hardly identifiable"
        table.add_row(
            figure.name, f"{figure.before:.4g}", f"{figure.value:.4g}", f"+- {figure.spread:.2g}{remark}", style=None
        )
    console.print(table)
    for what, before, after in (
        ("linear velocity", found.before.linear, found.after.linear),
        ("angular velocity", found.before.angular, found.after.angular),
    ):
        console.print(f"{what}: {before:.1%} off before, {after:.1%} after (root mean square of {found.seconds:.0f} s)")
    console.print(styled("saved to ", (str(path), "bold")))
