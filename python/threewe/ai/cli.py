"""`threewe policy`: train, look at, time and run learned policies."""

from __future__ import annotations

import asyncio
import json
import math
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import typer
from rich.table import Table

from threewe._console import plain_console, styled
from threewe._core import Velocity
from threewe._extras import needed_for
from threewe.ai.checkpoint import CONFIG, Checkpoint, is_checkpoint, read_checkpoint
from threewe.ai.folder import ACTION, EMBEDDED, GRAPH, LONGEST_LATENCY, STATE, read_policy, write_description
from threewe.ai.hub import is_hub_id, local_policy
from threewe.ai.runner import TICK, PolicyResult, VLARunner
from threewe.errors import ConfigError

app = typer.Typer(help="Learned policies.", no_args_is_help=True, rich_markup_mode=None)
console = plain_console()

Folder = Annotated[Path, typer.Argument(help="Of the policy, or the name of a shipped one: goto_v1.")]
Source = Annotated[
    str, typer.Argument(help="Folder of the policy; the name of a shipped one: goto_v1; or user/name of the Hub.")
]
Revision = Annotated[str | None, typer.Option(help="Of a policy of the Hub: branch, tag or commit; main if left out.")]


@app.command()
def train(
    datasets: Annotated[list[Path], typer.Argument(help="LeRobot datasets, such as `threewe data collect` writes.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder of the policy; must not exist.")],
    passes: Annotated[int, typer.Option(min=1, help="Over all rows.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Of the first weights and of the order.")] = 1,
    checks: Annotated[
        int,
        typer.Option(
            min=0,
            help="Generated buildings in which it drives after the later passes, to keep the best: 1.3 s of CPU each.",
        ),
    ] = 20,
    model: Annotated[
        Literal["film", "act"], typer.Option(help="film: 0.5 M weights; act: 12 M, which LeRobot loads, too.")
    ] = "film",
    prefix: Annotated[
        bool, typer.Option("--prefix", help="Learn to go on from actions that are committed when an inference begins.")
    ] = False,
    mirror: Annotated[
        bool,
        typer.Option("--mirror", help="Exchange left and right in half of the rows; for tasks that name no side."),
    ] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a training of the same options that was cut off.")
    ] = False,
    batch_size: Annotated[int, typer.Option(min=1, help="Rows of a step.")] = 64,
    device: Annotated[str, typer.Option(help="Where it learns, such as cuda.")] = "cpu",
) -> None:
    """Learn from demonstrations; writes a folder with policy.json, model.onnx and the curves of losses."""
    with needed_for("training a policy", "train"):
        import onnx  # noqa: F401 (missed now, not after the training)

        from threewe.ai.training import train_policy

    def progress(line: str) -> None:
        console.print(line, highlight=False)

    given = datasets, output, passes, seed, checks, progress, model, prefix, resume
    train_policy(*given, batch_size=batch_size, device=device, mirror=mirror)
    read_policy(output)
    console.print(styled("written to ", (str(output), "bold")), soft_wrap=True)


@app.command()
def info(source: Source, revision: Revision = None) -> None:
    """Check a policy's folder, or LeRobot's, and show what it needs and gives."""
    folder = local_policy(source, revision)
    table = Table("what", "is")
    if is_checkpoint(folder):
        for what, text in _about_checkpoint(read_checkpoint(folder)):
            table.add_row(what, text)
        console.print(table)
        return
    policy = read_policy(folder)
    table.add_row("robot", policy.kinematics.name)
    for camera in policy.cameras:
        table.add_row("camera", f"{camera.name}, {camera.height} x {camera.width}, {camera.color}")
    table.add_row("state", ", ".join(f"{each.name} [{each.unit}]" for each in policy.state) or "none")
    table.add_row("action", ", ".join(f"{each.name} [{each.unit}]" for each in policy.action))
    table.add_row("chunk", f"{policy.chunk} actions at {policy.rate:g} Hz, {policy.merge}")
    if policy.prefix:
        table.add_row("prefix", f"its first {policy.prefix} actions, as far as they are committed")
    table.add_row("latency", f"{policy.latency:g} s")
    table.add_row("language", "instruction_embedding" if policy.language else "none")
    for file in policy.files()[1:]:
        table.add_row(file.name, f"{file.stat().st_size / 1e6:.2f} MB")
    for name, value in policy.training.items():
        table.add_row(f"training: {name}", value)
    console.print(table)


def _about_checkpoint(checkpoint: Checkpoint) -> Iterator[tuple[str, str]]:
    """What one of LeRobot's needs and gives, which says neither its rate nor what its numbers are."""
    translated = checkpoint.kind == "act"
    yield "runs", "here, translated" if translated else "in LeRobot's own environment: python=.../bin/python"
    yield "kind", checkpoint.kind
    for name, feature in {**checkpoint.inputs, **checkpoint.outputs}.items():
        yield name, f"{feature.kind}, {' x '.join(map(str, feature.shape))}"
    yield (
        "text",
        "tokens" if checkpoint.reads_text else "instruction_embedding" if EMBEDDED in checkpoint.inputs else "none",
    )
    if checkpoint.rtc is not None:
        off = f'off: "rtc_config": {{"enabled": true}} in {CONFIG} switches it on'
        yield "rtc", "on: the actions that are committed go in with the picture" if checkpoint.rtc else off


@app.command()
def export(
    folder: Folder,
    int8: Annotated[bool, typer.Option("--int8", help="Eight bits, for processors.")] = False,
    hailo: Annotated[
        Path | None, typer.Option(help="Folder for Hailo's compiler: its input, its commands, and the policy's folder.")
    ] = None,
    arch: Annotated[str, typer.Option(help="Of the Hailo: hailo8l, hailo8, ...")] = "hailo8l",
    dataset: Annotated[
        Path | None, typer.Option(help="LeRobot dataset whose pictures choose the ranges; else generated buildings do.")
    ] = None,
    count: Annotated[int, typer.Option(min=10, max=10_000, help="Of observations that choose the ranges.")] = 200,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="FOLDER-int8 where left out.")] = None,
) -> None:
    """Write a policy in another form."""
    from threewe.ai.calibration import calibration_feeds
    from threewe.ai.cutting import COMMANDS, POLICY, write_for_hailo
    from threewe.ai.quantizing import write_int8

    if int8 == (hailo is not None):
        raise ConfigError("export: say --int8, or --hailo DIR")
    runner = VLARunner.from_pretrained(folder)
    if runner.policy.graph.name != GRAPH:
        raise ConfigError(f"{folder}: is in another form already; export from its {GRAPH}")
    feeds = calibration_feeds(runner, dataset, count)
    if hailo is not None:
        write_for_hailo(runner.policy, feeds, hailo, arch)
        console.print(f"{hailo / COMMANDS} compiles, and completes {hailo / POLICY}", highlight=False, soft_wrap=True)
        return
    target = output or Path(f"{folder.name}-int8")
    write_int8(runner.policy, feeds, target)
    read_policy(target)
    console.print(styled("written to ", (str(target), "bold")), soft_wrap=True)


@app.command()
def convert(
    checkpoint: Annotated[Path, typer.Argument(help="Folder of LeRobot's ACT: .../pretrained_model.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder of the policy; must not exist.")],
    dataset: Annotated[Path | None, typer.Option(help="That it was trained on: names and rate.")] = None,
    rate: Annotated[float | None, typer.Option(help="[Hz] of its actions, where there is no dataset.")] = None,
    rename: Annotated[
        list[str] | None, typer.Option(help="THEIRS=OURS, such as front=camera or action=vx,vy,omega; more than once.")
    ] = None,
) -> None:
    """Translate a checkpoint of LeRobot's ACT into a folder with policy.json and model.onnx."""
    from threewe.ai.loading import convert_checkpoint

    convert_checkpoint(checkpoint, output, _renamed(rename), rate, dataset)
    console.print(styled("written to ", (str(output), "bold")), soft_wrap=True)


def _renamed(pairs: list[str] | None) -> dict[str, str | list[str]] | None:
    """The `rename=` of options. Raises ConfigError."""
    if pairs is None:
        return None
    found: dict[str, str | list[str]] = {}
    for pair in pairs:
        theirs, _, ours = pair.partition("=")
        if not theirs or not ours:
            raise ConfigError(f"--rename: {pair!r} is no THEIRS=OURS, such as front=camera or action=vx,vy,omega")
        found[theirs] = ours.split(",") if "," in ours or theirs in (ACTION, STATE) else ours
    return found


@app.command()
def bench(
    source: Source,
    count: Annotated[int, typer.Option(min=1, max=100_000, help="Of inferences.")] = 200,
    write: Annotated[
        bool, typer.Option("--write", help="The 99 % into policy.json, as the latency that simulation charges.")
    ] = False,
    revision: Revision = None,
) -> None:
    """Time inferences on one thread of this machine."""
    if write and is_hub_id(source):
        raise ConfigError(f"{source}: what is on the Hub is not written to: hf download {source} --local-dir policy")
    runner = VLARunner.from_pretrained(source, revision=revision)
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
    if write:
        latency = round(TICK * math.ceil(slow / TICK), 2)
        if latency > LONGEST_LATENCY:
            raise ConfigError(f"{source}: {latency:g} s is more than a latency may be, {LONGEST_LATENCY:g} s")
        write_description(replace(runner.policy, latency=latency))
        console.print(f"latency {runner.policy.latency:g} s is {latency:g} s now", highlight=False)


@app.command("eval")
def evaluate(
    source: Source,
    episodes: Annotated[
        str, typer.Option(help="A set of ObjectNav by name or file; or generated: in buildings that follow from seeds.")
    ] = "in_sight_v1",
    backend: Annotated[
        list[str] | None, typer.Option(help="Where the robot is; more than once: ratios to the first. mock by default.")
    ] = None,
    count: Annotated[int, typer.Option(min=1, help="So many in each scene, or of generated buildings.")] = 100,
    seed: Annotated[
        list[int] | None, typer.Option(min=0, help="Of noise and of generated buildings, more than once for several.")
    ] = None,
    randomization: Annotated[str, typer.Option(help="Of the robot and its pictures.")] = "none",
    latency: Annotated[float | None, typer.Option(help="[s] in place of the policy's own.")] = None,
    other: Annotated[
        bool, typer.Option("--other", help="Name another kind that is in sight; a policy that listens should miss.")
    ] = False,
    workers: Annotated[int, typer.Option(min=1, help="Processes at a time.")] = 1,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="All figures, as JSON.")] = None,
    revision: Revision = None,
) -> None:
    """Drive to things that are in sight, and print SR and SPL with their 95 % intervals."""
    from threewe.ai.evaluating import Evaluation, summarize
    from threewe.ai.evaluating import evaluate as drive
    from threewe.benchmark.progress import progress

    what = Evaluation(episodes, tuple(backend or ["mock"]), count, tuple(seed or [0]), randomization, latency, other)
    policy = Path(local_policy(source, revision))
    with progress(f"{source}, {episodes}", None) as advance:
        figures = summarize(drive(policy, what, workers, advance))
    table = Table("backend", "episodes", "n", "SR", "95 %", "SPL", "95 %")
    for place, groups in figures.items():
        for name, row in groups.items():
            if name not in ("ends", "transfer"):
                cells = [text for kind in ("success", "spl") for text in _interval(row[kind])]
                table.add_row(place, name, str(row["count"]), *cells)
    console.print(table)
    for place, groups in figures.items():
        if "transfer" in groups:
            ratio, interval = _interval(groups["transfer"])
            console.print(f"SR on {place} / SR on {what.backends[0]}: {ratio} [{interval}]", highlight=False)
    if output is not None:
        output.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


def _interval(figure: dict[str, float]) -> tuple[str, str]:
    return f"{figure['value']:.3f}", f"{figure['low']:.2f} to {figure['high']:.2f}"


@app.command()
def serve(
    folder: Folder,
    host: Annotated[str, typer.Option(help="Address to listen on; others than loopback let all in who reach it.")] = (
        "127.0.0.1"
    ),
    port: Annotated[int, typer.Option(min=0, max=65535, help="0 is a free one.")] = 8000,
) -> None:
    """Compute actions for robots elsewhere, by openpi's websocket protocol: from_pretrained("ws://host:port")."""
    from threewe.ai.serving import PolicyServer

    server = PolicyServer(VLARunner.from_pretrained(folder), host, port)
    console.print(styled("serving at ", (server.address, "bold")), soft_wrap=True)
    server.serve_forever()


@app.command()
def run(
    source: Source,
    instruction: Annotated[str, typer.Option(help="Such as 'go to the chair'.")] = "",
    backend: Annotated[str, typer.Option(help="Where the robot is.")] = "mock",
    hardware: Annotated[str, typer.Option(help="Which robot.")] = "3we_standard_v2",
    scene: Annotated[str, typer.Option(help="Its name, or a file that ends in .yaml.")] = "office_v2",
    seed: Annotated[int, typer.Option(min=0, help="Of all noise.")] = 0,
    seconds: Annotated[float, typer.Option(help="Of robot time, at most.")] = 60.0,
    realtime: Annotated[bool, typer.Option("--realtime", help="As slowly as a real robot.")] = False,
    revision: Revision = None,
) -> None:
    """Let a policy drive a robot; exit status 1 unless it reached its goal, by its own judgement."""
    runner = VLARunner.from_pretrained(source, revision=revision)
    camera = runner.policy.cameras[0]
    size = (camera.height, camera.width)

    async def drive() -> PolicyResult:
        from threewe.robot import Robot

        async with Robot(backend, hardware, scene, seed=seed, realtime=realtime, image_size=size) as robot:
            return await runner.run(robot, instruction, timeout=seconds)

    result = asyncio.run(drive())
    detail = f", {result.detail}" if result.detail else ""
    unguided = f"{result.duration - result.guided:.1f} s of them without actions"
    counts = f"{unguided}, {result.inferences} inferences, {result.late} late, {result.jumps} jumps"
    counts += f", {result.recoveries} times away from what was too near"
    console.print(f"{result.reason}{detail}: {result.duration:.1f} robot s, {counts}", highlight=False, soft_wrap=True)
    if not result.success:
        raise typer.Exit(1)
