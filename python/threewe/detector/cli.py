"""`threewe detector`: train the object detector on pictures of generated buildings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from threewe._console import plain_console
from threewe._extras import needed_for
from threewe.errors import ConfigError

app = typer.Typer(help="The object detector of instructions.", no_args_is_help=True, rich_markup_mode=None)
console = plain_console()


@app.callback()
def detector() -> None:
    """The object detector of instructions."""


@app.command()
def train(
    output: Annotated[Path, typer.Option("--output", "-o", help="The detector, a file that ends in .safetensors.")],
    buildings: Annotated[int, typer.Option(min=1, help="Generated ones, 60 pictures of each.")] = 280,
    passes: Annotated[int, typer.Option(min=1, help="Over all pictures.")] = 24,
    seed: Annotated[int, typer.Option(min=0, help="Of buildings, poses and training.")] = 1,
    start: Annotated[Path | None, typer.Option(help="A detector like it, which is to learn on.")] = None,
    batch_size: Annotated[int, typer.Option(min=2, help="Pictures of a step.")] = 32,
    device: Annotated[str, typer.Option(help="Where it learns, such as cuda.")] = "cpu",
    workers: Annotated[int, typer.Option(min=1, help="Processes that draw pictures.")] = 1,
) -> None:
    """Draw pictures of generated buildings, learn from them, and write the detector in integers."""
    if output.suffix != ".safetensors":
        raise ConfigError(f"output: {output} must end in .safetensors")
    with needed_for("training a detector", "train"):
        from threewe.detector.pictures import labelled_pictures
        from threewe.detector.training import Pictures, some_pixels, train
        from threewe.detector.weights import load_network, save_detector

    pictures = list(labelled_pictures(seed, buildings, workers))
    if len(pictures) < batch_size:
        raise ConfigError(f"buildings: {buildings} give {len(pictures)} pictures; a step takes {batch_size}")
    console.print(f"{len(pictures)} pictures of {buildings} buildings")
    data = Pictures.of(pictures)
    before = load_network(start, some_pixels(data)) if start else None
    network = train(data, passes, seed, console.print, before, batch_size=batch_size, device=device)
    description = f"{len(pictures)} pictures of {buildings} generated buildings, {passes} passes"
    if start:
        description += f", begun with {start.stem}"
    save_detector(network, output, description)
