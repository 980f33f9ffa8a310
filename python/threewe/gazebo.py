"""Gazebo from the command line: `threewe gazebo`."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from threewe.errors import ConfigError
from threewe.exporting import export

app = typer.Typer(help="Worlds in Gazebo Harmonic.", no_args_is_help=True, rich_markup_mode=None)

INSTALL = "apt install gz-harmonic, from the packages that https://gazebosim.org/docs/harmonic/install names"


@app.command()
def launch(
    scene: Annotated[str, typer.Option(help="Name of a scene, or a file that ends in .yaml.")] = "office_v2",
    robot: Annotated[str, typer.Option(help="Hardware profile, or a file that ends in .yaml.")] = "3we_standard_v2",
    folder: Annotated[Path | None, typer.Option(help="Where the world is kept. [default: a temporary one]")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of Gazebo's noise.")] = 0,
) -> None:
    """Export a scene with a robot, and simulate it in Gazebo, without a window, as fast as it can.

    Robot(backend="gazebo", scene=..., hardware=...) then drives it, from any process of this user with the same
    GZ_PARTITION. Ctrl-C ends it.
    """
    with ExitStack() as kept:
        at = folder if folder is not None else Path(kept.enter_context(tempfile.TemporaryDirectory(prefix="threewe_")))
        world = write_world(scene, robot, at)
        program = shutil.which("gz")
        if program is None:
            raise ConfigError(f"Gazebo Harmonic is not installed: {INSTALL}")
        models = os.pathsep.join(filter(None, [str(at / "models"), os.environ.get("GZ_SIM_RESOURCE_PATH")]))
        command = [program, "sim", "-s", "-r", "--headless-rendering", "--seed", str(seed), str(world)]
        process = subprocess.Popen(command, env=os.environ | {"GZ_SIM_RESOURCE_PATH": models})
        signal.signal(signal.SIGTERM, lambda *_: process.terminate())  # as `kill %1` of a script sends it to us alone
        try:
            status = process.wait()
        except KeyboardInterrupt:  # it has received it, too
            status = process.wait()
    raise typer.Exit(status if status >= 0 else 0)


def write_world(scene: str, robot: str, folder: Path) -> Path:
    """An exported world that is not slowed down to the wall clock; the file."""
    world = next(file for file in export(scene, robot, "sdf", folder) if file.name == "world.sdf")
    factor = "<real_time_factor>{}</real_time_factor>"
    world.write_text(world.read_text().replace(factor.format(1), factor.format(0)))  # as fast as it can
    return world
