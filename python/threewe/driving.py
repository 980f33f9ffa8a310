"""The commands that drive a robot while one looks on: `threewe drive`, `threewe explore` and `threewe view`."""

from __future__ import annotations

import asyncio
import math
import os
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import Annotated, TypeVar

import typer

import threewe
from threewe._console import plain_console, styled
from threewe.terminal import Dashboard

console = plain_console()

Result = TypeVar("Result", threewe.MoveResult, threewe.ExploreResult)

SceneName = Annotated[str, typer.Option("--scene", help="Its name, or a file that ends in .yaml.")]
Backend = Annotated[str, typer.Option(help="Where the robot is.")]
Hardware = Annotated[str, typer.Option(help="Which robot.")]
Seed = Annotated[int, typer.Option(min=0, max=2**64 - 1, help="Of all noise.")]
Seconds = Annotated[float | None, typer.Option(help="Of robot time, at most.")]
Thorough = Annotated[bool, typer.Option("--thorough", help="Also the last corners, which are far for what they show.")]
Realtime = Annotated[bool, typer.Option("--realtime", help="As slowly as a real robot.")]
Rerun = Annotated[bool, typer.Option("--rerun", help="Show it in the Rerun viewer, too.")]
Save = Annotated[Path | None, typer.Option(metavar="FILE.rrd", help="Record it for the Rerun viewer.")]
Serve = Annotated[bool, typer.Option("--serve", help="Serve the Rerun viewer to browsers on this machine.")]
ServeNetwork = Annotated[
    bool,
    typer.Option("--serve-network", help="Serve it to everyone on the network: all can watch, without a password."),
]
Map = Annotated[
    Path | None, typer.Option("--map", metavar="FILE.yaml", help="A map to find itself in, as ROS has maps.")
]
SaveMap = Annotated[
    Path | None, typer.Option(metavar="DIR/NAME", help="Leave the map there in the end: NAME.yaml and NAME.pgm.")
]


def drive(
    to: Annotated[
        tuple[float, float], typer.Option(help="Where to, in metres: from where the robot starts, or in --map.")
    ],
    heading: Annotated[float | None, typer.Option(help="To turn to in the end, in degrees.")] = None,
    scene: SceneName = "office_v2",
    backend: Backend = "mock",
    hardware: Hardware = "3we_standard_v2",
    seed: Seed = 0,
    seconds: Seconds = None,
    realtime: Realtime = False,
    prior_map: Map = None,
    save_map: SaveMap = None,
    rerun: Rerun = False,
    save: Save = None,
    serve: Serve = False,
    serve_network: ServeNetwork = False,
) -> None:
    """Drive to a place, through a scene that the robot has never seen or has a map of."""
    audience = Audience(rerun, save, serve, serve_network)
    keep = map_file(save_map)
    robot = threewe.Robot(backend, hardware, scene, prior_map, seed=seed, realtime=realtime, viewer=audience.viewer)
    theta = None if heading is None else math.radians(heading)
    task = f"driving to ({to[0]:g}, {to[1]:g})"
    result = watch(robot, task, to, keep, lambda look: robot.move_to(*to, theta, timeout=seconds, on_progress=look))
    tell(result, f"{result.distance_to_goal:.2f} m from the goal by its own belief")
    tell_of_map(keep)
    audience.leave()
    if not result.success:
        raise typer.Exit(1)


def explore(
    scene: SceneName = "office_v2",
    backend: Backend = "mock",
    hardware: Hardware = "3we_standard_v2",
    seed: Seed = 0,
    thorough: Thorough = False,
    seconds: Seconds = None,
    realtime: Realtime = False,
    prior_map: Map = None,
    save_map: SaveMap = None,
    rerun: Rerun = False,
    save: Save = None,
    serve: Serve = False,
    serve_network: ServeNetwork = False,
) -> None:
    """Map a scene that the robot has never seen, or what a map of it lacks."""
    audience = Audience(rerun, save, serve, serve_network)
    keep = map_file(save_map)
    robot = threewe.Robot(backend, hardware, scene, prior_map, seed=seed, realtime=realtime, viewer=audience.viewer)
    task = f"exploring {scene}"
    result = watch(
        robot, task, None, keep, lambda look: robot.explore(thorough=thorough, timeout=seconds, on_progress=look)
    )
    tell(result, f"{result.explored_area:.0f} m² explored")
    tell_of_map(keep)
    audience.leave()
    if result.reason not in (threewe.Reason.reached, threewe.Reason.timeout):
        raise typer.Exit(1)


def view(
    scene: Annotated[str, typer.Argument(help="Its name, or a file that ends in .yaml.")] = "office_v2",
    backend: Backend = "mock",
    hardware: Hardware = "3we_standard_v2",
    seed: Seed = 0,
    seconds: Seconds = None,
    realtime: Realtime = False,
    save: Save = None,
    serve: Serve = False,
    serve_network: ServeNetwork = False,
) -> None:
    """Watch a robot explore a scene, in the Rerun viewer."""
    rerun = not save and not serve and not serve_network
    options = (scene, backend, hardware, seed)
    explore(
        *options, seconds=seconds, realtime=realtime, rerun=rerun, save=save, serve=serve, serve_network=serve_network
    )


@dataclass
class Audience:
    """Viewers besides the terminal."""

    rerun: bool
    save: Path | None
    serve: bool
    serve_network: bool

    @property
    def viewer(self) -> str | None:
        """As `Robot` takes it. Raises ConfigError where more than one is chosen."""
        chosen = [self.rerun, self.save is not None, self.serve, self.serve_network]
        if sum(chosen) > 1:
            raise threewe.ConfigError(
                "choose one: --rerun opens a window, --save records, --serve serves browsers on this machine, "
                "--serve-network everyone on the network"
            )
        if self.save is not None and self.save.suffix != ".rrd":
            raise threewe.ConfigError(f"the name of a recording ends in .rrd, not '{self.save.suffix}'")
        ways = {"rerun": self.rerun, "web": self.serve, "network": self.serve_network, str(self.save): bool(self.save)}
        return next((way for way, is_chosen in ways.items() if is_chosen), None)

    def leave(self) -> None:
        """Says where the recording is; browsers are served until Ctrl-C."""
        if self.save is not None:
            name = str(self.save)
            console.print(styled("recorded to ", (name, "bold"), f"; open it with: rerun {name}"), soft_wrap=True)
        if self.serve or self.serve_network:
            with suppress(KeyboardInterrupt):
                console.print("serving until Ctrl-C")
                Event().wait()


def map_file(name: Path | None) -> Path | None:
    """The file that `--save-map` names. Raises ConfigError, before anything is driven, where it cannot be written."""
    if name is None:
        return None
    if name.suffix not in ("", ".yaml"):
        raise threewe.ConfigError(f"--save-map: the name of a map ends in .yaml or in nothing, not '{name.suffix}'")
    if not name.parent.is_dir():
        raise threewe.ConfigError(f"--save-map: there is no folder '{name.parent}'")
    file = name.with_suffix(".yaml")
    for part in (file, file.with_suffix(".pgm")):
        if part.is_dir() or not os.access(part if part.exists() else part.parent, os.W_OK):
            raise threewe.ConfigError(f"--save-map: '{part}' cannot be written")
    return file


def watch(
    robot: threewe.Robot,
    task: str,
    goal: tuple[float, float] | None,
    keep: Path | None,
    motion: Callable[[Dashboard], Awaitable[Result]],
) -> Result:
    """Connects, lets a motion run to its end, drawn in the terminal, and keeps the map however it ended."""

    async def run() -> Result:
        async with robot:
            if keep is not None:
                robot.get_map()  # who has none says so now, not after the drive
            with Dashboard(robot, console, task, goal) as dashboard:
                result = await motion(dashboard)
            if keep is not None:
                robot.save_map(keep)
            return result

    return asyncio.run(run())


def tell(result: threewe.MoveResult | threewe.ExploreResult, figures: str) -> None:
    """How it ended."""
    color = "green" if result.success else "yellow"
    why = f", {result.detail}" if result.detail else ""
    driven = f"{result.distance:.1f} m driven in {result.duration:.0f} robot s"
    reason = (result.reason.name, f"bold {color}")
    console.print(styled(reason, f"{why}: {driven}, {figures}"), soft_wrap=True)


def tell_of_map(file: Path | None) -> None:
    """Where it is."""
    if file is not None:
        console.print(styled("map saved to ", (str(file), "bold")), soft_wrap=True)
