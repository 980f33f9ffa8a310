"""`threewe instruct`: one sentence, and a simulated robot does it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from threewe._console import plain_console
from threewe._extras import needed_for

console = plain_console()


def instruct(
    instruction: Annotated[str, typer.Argument(help='Such as "find the red chair".')],
    scene: Annotated[str, typer.Option(help="Scene by name, or a file that ends in .yaml.")] = "office_v2",
    backend: Annotated[str, typer.Option(help="Backend.")] = "mock",
    hardware: Annotated[str, typer.Option(help="Robot profile, one with a camera.")] = "3we_standard_v2",
    seed: Annotated[int, typer.Option(min=0, help="Of all noise.")] = 0,
    timeout: Annotated[float, typer.Option(min=1.0, help="[s] of robot time.")] = 900.0,
    report: Annotated[
        Path | None, typer.Option(help="Page with map, way and pictures, a file that ends in .html.")
    ] = None,
    map: Annotated[Path | None, typer.Option(help="A map to be localised in, a file that ends in .yaml.")] = None,
    places: Annotated[Path | None, typer.Option(help="Places in that map by name, a file that ends in .yaml.")] = None,
    model: Annotated[
        str | None,
        typer.Option(help="Address of an OpenAI-compatible server, #NAME for one of its models; or a name at OpenAI."),
    ] = None,
    require_vision: Annotated[bool, typer.Option(help="A model that does not see is an error.")] = False,
    thinking_time: Annotated[
        float | None, typer.Option(min=0.0, help="[s] of robot time for each answer of a model; measured without.")
    ] = None,
    record: Annotated[Path | None, typer.Option(help="File for the conversation with a model.")] = None,
    replay: Annotated[Path | None, typer.Option(help="Such a file: the same run again, without a server.")] = None,
) -> None:
    """Do what a sentence says, offline: read by a grammar, seen by the detector that comes with 3we. Or by a model."""
    from threewe.sync import Robot

    if report is not None:
        with needed_for("a report", "demo"):
            from threewe._instruction_report import check_page
        check_page(report)  # before the robot drives

    with Robot(backend=backend, hardware=hardware, scene=scene, seed=seed, map=map) as robot:
        if places is not None:
            robot.load_places(places)
        result = robot.execute_instruction(
            instruction,
            timeout=timeout,
            model=model,
            require_vision=require_vision,
            thinking_time=thinking_time,
            record=record,
            replay=replay,
        )
    for step in result.steps:
        console.print(f"{step.begun:7.1f} s  {step.text}: {step.reason}" + (f", {step.detail}" if step.detail else ""))
    said = result.answer or result.detail
    console.print(f"{result.reason}{': ' + said if said else ''}")
    console.print(
        f"{result.distance:.1f} m driven in {result.duration:.1f} s, verified: {'yes' if result.verified else 'no'}"
    )
    if result.tokens:
        console.print(f"a model thought for {result.thinking:.1f} s of that, with {result.tokens} tokens")
    if report is not None:
        result.save(report)
        console.print(f"report: {report}")
    if not result.success:
        raise typer.Exit(1)
