"""The commands `threewe data export | show`: recordings in the formats of others, and at a glance."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from threewe._console import plain_console, styled
from threewe.data.cli_datasets import numbers, progress
from threewe.errors import ConfigError

console = plain_console()


def export(
    recording: Annotated[Path, typer.Argument(help="Folder of a recording, or a journal.")],
    output: Annotated[
        Path,
        typer.Option("--output", "-o", help="What must not exist: a folder; of hdf5, or of one episode, a file."),
    ],
    format: Annotated[
        Literal["lerobot", "hdf5", "mcap", "rerun", "tum"],
        typer.Option("--format", "-f", help="mcap with Foxglove's schemas; tum are trajectories alone."),
    ] = "lerobot",
    fps: Annotated[float | None, typer.Option(help="Rows a second of a LeRobot dataset; 50 by default.")] = None,
    version: Annotated[Literal["v3.0", "v2.1"] | None, typer.Option(help="Of LeRobot's format.")] = None,
    codec: Annotated[
        Literal["copy", "h264", "av1"] | None,
        typer.Option(help="Of a LeRobot dataset; copy takes over what is encoded."),
    ] = None,
    hardware: Annotated[
        str | None, typer.Option(help="Another robot profile than the recorded one, which says where its sensors are.")
    ] = None,
    truth: Annotated[
        bool, typer.Option("--truth", help="tum: the true trajectory, too, of a simulated robot.")
    ] = False,
) -> None:
    """Write a recording for others to read."""
    from threewe.data.exporting import export as write
    from threewe.data.recording import Recording

    options: dict[str, str | bool] = {}
    for name, value in (("version", version), ("codec", codec), ("hardware", hardware), ("truth", truth or None)):
        if value is not None:
            options[name] = value
    count = 0
    with progress("exporting") as tell:

        def counted(done: int, total: int) -> None:
            nonlocal count
            count = done
            tell(done, total)

        made = write(Recording(recording), output, format, fps=fps, on_progress=counted, **options)
    console.print(styled((str(made), "bold"), f": {count} episode{'s' * (count != 1)} as {format}"), soft_wrap=True)


def show(
    source: Annotated[Path, typer.Argument(help="Folder of a recording or of a LeRobot dataset, or a journal.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The picture, .png; the source's name by default.")
    ] = None,
    episodes: Annotated[str | None, typer.Option(help="Numbers, such as 0,3,7-9; the first twelve by default.")] = None,
    frames: Annotated[int, typer.Option(min=1, max=20, help="Of each episode.")] = 5,
    rerun: Annotated[bool, typer.Option("--rerun", help="Open an episode in Rerun; no picture is made.")] = False,
) -> None:
    """Make a contact sheet: task, success, frames and trajectory of each episode. Or open Rerun."""
    from threewe.data.showing import show as write
    from threewe.data.showing import show_in_rerun

    chosen = None if episodes is None else numbers(episodes)
    if rerun:
        if output is not None:
            raise ConfigError("--rerun opens a window and makes no picture: leave out --output")
        if chosen is not None and len(chosen) != 1:
            raise ConfigError(f"--rerun opens one episode, got {len(chosen)}")
        show_in_rerun(source, None if chosen is None else chosen[0])
        return
    with progress("drawing") as tell:
        made = write(
            source,
            output or Path(f"{source.resolve().stem}.png"),
            episodes=chosen,
            frames=frames,
            on_progress=tell,
        )
    console.print(styled((str(made), "bold")), soft_wrap=True)
