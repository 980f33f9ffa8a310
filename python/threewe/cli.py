"""The command `threewe`."""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.table import Column, Table

import threewe
from threewe import calibration, driving, gazebo, instructing, profiles, ros2, teleoperation
from threewe._console import plain_console, styled
from threewe.ai import cli as policy
from threewe.benchmark import cli as benchmark
from threewe.benchmark import cli_transfer
from threewe.data import cli as data
from threewe.detector import cli as detector
from threewe.slam import cli as slam

app = typer.Typer(
    help="3we: one robot program, on simulators and on the robot.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # it takes [m] in a help text for markup
)
scenes = typer.Typer(
    help="Scenes: those that come with 3we, your own, and new ones.", no_args_is_help=True, rich_markup_mode=None
)
app.add_typer(scenes, name="scenes")
app.add_typer(profiles.app, name="hardware")
app.add_typer(slam.app, name="slam")
app.add_typer(data.app, name="data")
app.add_typer(ros2.app, name="ros2")
app.add_typer(gazebo.app, name="gazebo")
app.add_typer(detector.app, name="detector")
app.add_typer(policy.app, name="policy")
app.add_typer(benchmark.app, name="benchmark")
app.add_typer(cli_transfer.app, name="transfer")
for command in (driving.drive, driving.explore, driving.view):
    app.command()(command)
app.command("calibrate")(calibration.command)
app.command()(teleoperation.teleop)
app.command()(instructing.instruct)

console = plain_console()
complaints = plain_console(stderr=True)

EXTRAS = {
    "PIL": "demo",
    "av": "data",
    "pyarrow": "data",
    "h5py": "data",
    "mcap": "data",
    "huggingface_hub": "data",
    "rosbags": "logs",
}  # the modules that commands import and not every installation has


def main() -> None:
    """Runs the command line; an error that the user can mend is one line, not a traceback."""
    try:
        app()
    except (threewe.ThreeweError, OSError) as error:
        fail(str(error))
    except ModuleNotFoundError as error:
        if error.name not in EXTRAS:
            raise
        fail(f"{error.name} is not installed: {sys.executable} -m pip install 'threewe[{EXTRAS[error.name]}]'")


def fail(message: str) -> NoReturn:
    """Ends the program."""
    complaints.print(styled(("error:", "bold red"), f" {message}"), highlight=False, soft_wrap=True)
    raise SystemExit(2)


@app.command()
def demo(
    scene: Annotated[str, typer.Option(help="Where.")] = "office_v2",
    hardware: Annotated[str, typer.Option(help="Which robot.")] = "3we_standard_v2",
    place: Annotated[str, typer.Option(help="The room to drive to in the end.")] = "kitchen",
    seed: Annotated[int, typer.Option(help="Of all noise.")] = 0,
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")] = Path("demo"),
) -> None:
    """Explore a scene, draw its map, drive to a room; leaves map.png, camera.png, run.gif, run.mp4 and summary.json."""
    import av  # noqa: F401 (missed now, not after the drive)

    from threewe.demo import run

    summary = asyncio.run(run(scene, hardware, place, seed, output, console))
    files = "run.mp4, run.gif, map.png, camera.png, summary.json"
    console.print(styled("The film is in ", (f"{output}/", "bold"), f": {files}"))
    if not summary.arrived:
        raise typer.Exit(1)


@scenes.command("list")
def list_scenes() -> None:
    """The scenes, also those in folders that THREEWE_PATH names, with their sizes and rooms."""
    table = Table("scene", "size", "rooms", "objects", Column("description", overflow="fold"))
    broken = False
    for name in threewe.scene_names():
        try:
            scene = threewe.Scene.load(name)
        except threewe.ConfigError as error:
            table.add_row(name, styled(("broken", "bold red")), "", "", str(error))
            broken = True
            continue
        width, depth = scene.max[0] - scene.min[0], scene.max[1] - scene.min[1]
        counts = str(len(scene.rooms)), str(len(scene.objects))
        table.add_row(name, f"{width:.0f} x {depth:.0f} m", *counts, scene.description)
    console.print(table)
    if broken:
        raise typer.Exit(1)


@scenes.command("show")
def show_scene(
    name: str,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="The picture; NAME.png by default.")] = None,
    width: Annotated[int, typer.Option(min=64, max=8192, help="Of the picture, in pixels.")] = 1200,
) -> None:
    """Draw a scene from above into a picture, and list its rooms."""
    from threewe import drawing

    scene = threewe.Scene.load(name)
    path = output or Path(f"{scene.name}.png")
    if path.suffix.lower() not in (".png", ".jpg", ".jpeg") or path.is_dir():
        raise threewe.ConfigError(f"--output: a picture ends in .png or .jpg, not '{path}'")
    picture = drawing.finish(drawing.draw_scene(scene, drawing.View.of(scene, width)))
    picture.save(path)
    table = Table("room", "x", "y", "floor")
    for room in scene.rooms:
        table.add_row(room.name, f"{room.anchor[0]:.1f}", f"{room.anchor[1]:.1f}", room.floor)
    console.print(table)
    console.print(styled("drawn to ", (str(path), "bold")))


@scenes.command("generate")
def generate_scene(
    seed: Annotated[int, typer.Option(min=0, max=2**64 - 1, help="Draws the scene.")],
    difficulty: Annotated[float, typer.Option(help="0 to 1: from sparse to crowded.")] = 0.5,
    size: Annotated[tuple[float, float], typer.Option(help="East to west and south to north, in metres.")] = (
        14.0,
        10.0,
    ),
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The file; generated_SEED.yaml by default.")
    ] = None,
) -> None:
    """Draw a new scene from a seed and save it; `threewe scenes show FILE` and `Robot(scene=FILE)` take the file."""
    scene = threewe.Scene.generate(seed, difficulty=difficulty, size=size)
    path = output or Path(f"{scene.name}.yaml")
    if path.suffix != ".yaml":
        raise threewe.ConfigError(f"the name of a scene's file ends in .yaml, not '{path.suffix}'")
    path.write_text(scene.to_yaml(name=path.stem), encoding="utf-8")
    counts = f"{len(scene.rooms)} rooms, {len(scene.objects)} objects"
    console.print(styled(f"{counts}, saved to ", (str(path), "bold")))


@app.command("export")
def export_to(
    format: Annotated[
        str, typer.Option(help="mjcf (MuJoCo), urdf (ROS 2), sdf (Gazebo), usd (Isaac Sim) or map (ROS).")
    ],
    scene: Annotated[str, typer.Option(help="Its name, or a file that ends in .yaml.")] = "office_v2",
    robot: Annotated[str, typer.Option(help="Its name, or a file that ends in .yaml.")] = "3we_standard_v2",
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the files.")] = Path("export"),
    places: Annotated[bool, typer.Option("--places", help="Of a map: its rooms too, as places.yaml.")] = False,
) -> None:
    """Write a scene and a robot for other simulators and for ROS."""
    for path in threewe.export(scene, robot, format, output, places=places):
        console.print(str(path), highlight=False, soft_wrap=True)


@app.command()
def doctor() -> None:
    """What is installed, what works, and what to do about the rest."""
    from threewe.doctor import examine

    table = Table("part", Column("state", overflow="fold"), Column("what to do", overflow="fold"))
    findings = examine()
    for finding in findings:
        color = {"ok": "green", "missing": "yellow", "broken": "bold red"}[finding.state]
        table.add_row(finding.part, styled((finding.state, color), f" {finding.detail}"), finding.remedy)
    console.print(table)
    if any(finding.state == "broken" for finding in findings):
        raise typer.Exit(1)


@app.command()
def version() -> None:
    """The version of 3we."""
    console.print(threewe.__version__, highlight=False)
