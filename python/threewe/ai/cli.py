"""`threewe policy`: train, look at, time and run learned policies."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from threewe._console import plain_console, styled
from threewe._core import Velocity
from threewe._extras import needed_for
from threewe.ai.folder import GRAPH, read_policy
from threewe.ai.runner import PolicyResult, VLARunner

app = typer.Typer(help="Learned policies.", no_args_is_help=True, rich_markup_mode=None)
console = plain_console()

Folder = Annotated[Path, typer.Argument(help="Of the policy.")]


@app.command()
def train(
    dataset: Annotated[Path, typer.Argument(help="A LeRobot dataset, such as `threewe data collect` writes.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder of the policy; must not exist.")],
    passes: Annotated[int, typer.Option(min=1, help="Over all rows.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Of the first weights and of the order.")] = 1,
) -> None:
    """Learn from demonstrations; writes a folder with policy.json and model.onnx."""
    with needed_for("training a policy", "train"):
        import onnx  # noqa: F401 (missed now, not after the training)

        from threewe.ai.training import train_policy

    train_policy(dataset, output, passes, seed, lambda line: console.print(line, highlight=False))
    read_policy(output)
    console.print(styled("written to ", (str(output), "bold")), soft_wrap=True)


@app.command()
def info(folder: Folder) -> None:
    """Check a policy's folder, and show what it needs and gives."""
    policy = read_policy(folder)
    table = Table("what", "is")
    table.add_row("robot", policy.kinematics.name)
    for camera in policy.cameras:
        table.add_row("camera", f"{camera.name}, {camera.height} x {camera.width}, {camera.color}")
    table.add_row("state", ", ".join(f"{each.name} [{each.unit}]" for each in policy.state) or "none")
    table.add_row("action", ", ".join(f"{each.name} [{each.unit}]" for each in policy.action))
    table.add_row("chunk", f"{policy.chunk} actions at {policy.rate:g} Hz, {policy.merge}")
    table.add_row("latency", f"{policy.latency:g} s")
    table.add_row("language", "instruction_embedding" if policy.language else "none")
    table.add_row("graph", f"{(folder / GRAPH).stat().st_size / 1e6:.2f} MB")
    for name, value in policy.training.items():
        table.add_row(f"training: {name}", value)
    console.print(table)


@app.command()
def bench(folder: Folder, count: Annotated[int, typer.Option(min=1, max=100_000, help="Of inferences.")] = 200) -> None:
    """Time inferences on one thread of this machine."""
    runner = VLARunner.from_pretrained(folder)
    camera = runner.policy.cameras[0]
    picture = np.zeros((camera.height, camera.width, 3), np.uint8)
    instruction = "go to the chair" if runner.policy.language else ""
    times = []
    for _ in range(count + 10):  # the first ten warm up
        begun = time.perf_counter()
        runner.predict_chunk(picture, instruction, velocity=Velocity())
        times.append(time.perf_counter() - begun)
    median, slow = np.quantile(times[10:], [0.5, 0.99])
    text = f"{1e3 * median:.2f} ms (99 %: {1e3 * slow:.2f} ms), {1 / median:.0f} Hz, on one thread"
    console.print(text, highlight=False)


@app.command()
def run(
    folder: Folder,
    instruction: Annotated[str, typer.Option(help="Such as 'go to the chair'.")] = "",
    backend: Annotated[str, typer.Option(help="Where the robot is.")] = "mock",
    hardware: Annotated[str, typer.Option(help="Which robot.")] = "3we_standard_v2",
    scene: Annotated[str, typer.Option(help="Its name, or a file that ends in .yaml.")] = "office_v2",
    seed: Annotated[int, typer.Option(min=0, help="Of all noise.")] = 0,
    seconds: Annotated[float, typer.Option(help="Of robot time, at most.")] = 60.0,
    realtime: Annotated[bool, typer.Option("--realtime", help="As slowly as a real robot.")] = False,
) -> None:
    """Let a policy drive a robot; exit status 1 unless it reached its goal, by its own judgement."""
    runner = VLARunner.from_pretrained(folder)
    camera = runner.policy.cameras[0]
    size = (camera.height, camera.width)

    async def drive() -> PolicyResult:
        from threewe.robot import Robot

        async with Robot(backend, hardware, scene, seed=seed, realtime=realtime, image_size=size) as robot:
            return await runner.run(robot, instruction, timeout=seconds)

    result = asyncio.run(drive())
    detail = f", {result.detail}" if result.detail else ""
    counts = f"{result.inferences} inferences, {result.late} late, {result.jumps} jumps"
    console.print(f"{result.reason}{detail}: {result.duration:.1f} robot s, {counts}", highlight=False, soft_wrap=True)
    if not result.success:
        raise typer.Exit(1)
