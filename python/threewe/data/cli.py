"""The commands `threewe data ...`."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Annotated, Literal

import typer
from rich.table import Table

from threewe._console import plain_console, styled
from threewe.data import cli_datasets, cli_formats, cli_hub

app = typer.Typer(
    help="Recordings and datasets: record, look at, export, check, edit and share them.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
for command in (cli_datasets.validate, cli_datasets.convert, cli_datasets.merge, cli_datasets.split):
    app.command()(command)
app.command("filter")(cli_datasets.filter_)
app.command()(cli_datasets.append)
app.command()(cli_hub.push)
app.command()(cli_hub.pull)
app.command("export")(cli_formats.export)
app.command()(cli_formats.show)

console = plain_console()


@app.command()
def record(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder of the journals; may hold some already.")],
    driver: Annotated[
        Literal["person", "navigator", "both"],
        typer.Option(help="Who drives: you; the robot itself, to goals drawn at random; or it, until you take over."),
    ] = "person",
    episodes: Annotated[int, typer.Option(min=1, help="So many drives, where the navigator drives alone.")] = 10,
    task: Annotated[str, typer.Option(help="What the episodes say that the robot is to do.")] = "go to the goal",
    backend: Annotated[str, typer.Option(help="Where the robot is.")] = "mock",
    hardware: Annotated[str, typer.Option(help="Which robot.")] = "3we_standard_v2",
    scene: Annotated[str, typer.Option(help="Where, in a simulator.")] = "office_v2",
    seed: Annotated[int, typer.Option(min=0, help="Of all noise, and of the goals.")] = 0,
    input: Annotated[
        Literal["auto", "keyboard", "gamepad"], typer.Option(help="What you drive with; auto: a gamepad where one is.")
    ] = "auto",
    device: Annotated[Path | None, typer.Option(help="Of the gamepad, /dev/input/event*.")] = None,
) -> None:
    """Record episodes: of your driving, of the robot's own, or of its own with your corrections.

    Where you drive: R starts an episode, Enter ends it as a success, F as a failure, Backspace discards it.
    """
    from threewe.data import collecting

    if driver == "navigator":
        work = collecting.collect(output, episodes, backend, hardware, scene, seed, task)
        console.print(styled(*asyncio.run(work)), highlight=False, soft_wrap=True)
        return
    from threewe.teleop.session import run_until_ended

    by_itself = driver == "both"
    kept = run_until_ended(
        collecting.drive(output, backend, hardware, scene, seed, task, console, input, device, by_itself=by_itself)
    )
    console.print(styled(f"{kept} episodes kept in ", (f"{output}/", "bold")), highlight=False, soft_wrap=True)


@app.command()
def collect(
    output: Annotated[Path, typer.Option("--output", "-o", help="The LeRobot dataset; must not exist.")],
    task: Annotated[
        Literal["goto", "objectnav", "vln"],
        typer.Option(
            help="Drive to a thing that is in view, to one that is anywhere, or as a description of a way says."
        ),
    ] = "goto",
    teacher: Annotated[
        Literal["navigator", "instruction"],
        typer.Option(help="The navigator, which is given the goal; or execute_instruction, offline, which is not."),
    ] = "navigator",
    episodes: Annotated[int, typer.Option(min=1, help="So many drives.")] = 100,
    scene: Annotated[
        str, typer.Option(help="Where; procedural: in generated buildings; varied: in fuller ones.")
    ] = "procedural",
    backend: Annotated[str, typer.Option(help="A simulator.")] = "mock",
    hardware: Annotated[str, typer.Option(help="Which robot.")] = "3we_standard_v2",
    randomization: Annotated[str, typer.Option(help="Of the robot and its pictures.")] = "none",
    disturbance: Annotated[
        str,
        typer.Option(
            help="What takes the robot off the navigator's way: bursts of random commands, none, or a policy's folder."
        ),
    ] = "random",
    seed: Annotated[int, typer.Option(min=0, help="Of buildings, tasks and noise.")] = 0,
    image_size: Annotated[
        tuple[int, int] | None,
        typer.Option(help="Height and width [px] of the pictures; 60 80 unless said, of instruction 240 320."),
    ] = None,
) -> None:
    """Collect demonstrations for `threewe policy train`: pictures, instructions and what a teacher does."""
    from threewe.ai import collecting

    how = collecting.Collection(task, teacher, scene, backend, hardware, randomization, disturbance, seed, image_size)
    arrived = asyncio.run(collecting.collect_demonstrations(output, episodes, how))
    text = f"{arrived} of {episodes} arrived ({task}, {teacher}); the dataset is in "
    console.print(styled(text, (f"{output}/", "bold")), highlight=False, soft_wrap=True)


@app.command()
def recover(folder: Annotated[Path, typer.Argument(help="Folder of a recording.")]) -> None:
    """Finish the episodes that a crash has cut off; nothing of what was on the disk is lost."""
    from threewe.data import recover as finish
    from threewe.data.recording import CONTROL_RATE
    from threewe.data.step_files import recover_steps

    found = finish(folder)
    steps = recover_steps(folder)
    for one in found:
        if one.file.name:
            what = f"{one.ticks / CONTROL_RATE:.1f} s saved, {one.lost_bytes} torn bytes left out"
            console.print(styled((one.file.name, "bold"), f": {what}"), highlight=False)
        else:
            console.print("an episode had nothing yet", highlight=False)
    for file, count in steps:
        saved = styled((file.name, "bold"), f": {count} steps saved") if file else "an episode had no steps yet"
        console.print(saved, highlight=False)
    if not found and not steps:
        console.print("nothing was cut off", highlight=False)


@app.command()
def info(
    path: Annotated[Path, typer.Argument(help="Folder of a recording or of a LeRobot dataset, or a journal.")],
) -> None:
    """Show what a recording or a dataset holds."""
    if (path / "meta").is_dir():
        return cli_datasets.info(path)
    import numpy as np

    from threewe.data import Recording

    table = Table("episode", "robot", "task", "success", "length", "driven", "sensors")
    for episode in Recording(path):
        driven = np.linalg.norm(np.diff(episode.odom_from_base[:, :2], axis=0), axis=1).sum()
        judged = {None: "-", True: "yes", False: "no"}[episode.success] + (" (cut off)" if episode.recovered else "")
        length = f"{len(episode.time) / episode.control_rate:.1f} s"
        cells = str(episode.index), episode.robot_type, episode.task, judged, length, f"{driven:.1f} m"
        table.add_row(*cells, ", ".join([*episode.cameras, "lidar"] if "lidar" in episode.sensors else episode.cameras))
    console.print(table)
    return None


@app.command()
def replay(
    recording: Annotated[Path, typer.Argument(help="A journal, or a folder of them; or a LeRobot dataset of 3we.")],
    backend: Annotated[
        str | None, typer.Option(help="Drive a robot there; where left out, make the recorded world anew.")
    ] = None,
    scene: Annotated[str, typer.Option(help="Of that backend.")] = "office_v2",
    episode: Annotated[int | None, typer.Option(min=0, help="One of them alone.")] = None,
) -> None:
    """Let a robot do what was recorded, and say how far it comes from it; exit status 1 where a world differs."""
    from threewe.data.replaying import replay_all

    different = False
    for line, same in replay_all(recording, backend, scene, episode):
        console.print(line, highlight=False)
        different = different or not same
    if different:
        raise typer.Exit(1)
