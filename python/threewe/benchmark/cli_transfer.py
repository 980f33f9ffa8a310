"""`threewe transfer`: how much of a policy's success on one backend it has on another."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from threewe._console import plain_console, styled
from threewe.benchmark.progress import progress
from threewe.errors import ConfigError

app = typer.Typer(help="Transfer of policies from one backend to another.", no_args_is_help=True, rich_markup_mode=None)
console = plain_console()


@app.callback()
def transfer() -> None:
    """Transfer of policies from one backend to another."""


@app.command()
def run(
    policy: Annotated[
        str,
        typer.Option(help="policy:FOLDER, FILE.onnx or .safetensors, module:Class, or an agent that comes with 3we."),
    ],
    source: Annotated[str, typer.Option(help="Backend that the policy comes from.")] = "mock",
    target: Annotated[str, typer.Option(help="Backend that it goes to.")] = "mujoco",
    task: Annotated[str, typer.Option(help="pointnav or objectnav.")] = "pointnav",
    episodes: Annotated[int, typer.Option(min=1, help="On the source, from all scenes in turn.")] = 50,
    seeds: Annotated[int, typer.Option(min=1, help="Of noise, for each episode on the source.")] = 3,
    matched: Annotated[int, typer.Option("--target-episodes", min=1, help="The first of them, on the target.")] = 10,
    scene: Annotated[
        list[str] | None, typer.Option(help="A scene, more than once for several; all of the set.")
    ] = None,
    split: Annotated[str, typer.Option(help="val, test, or a set of episodes by name or file.")] = "val",
    workers: Annotated[int, typer.Option(min=1, help="Processes at a time.")] = 1,
    output: Annotated[Path, typer.Option("--output", "-o", help="The result.")] = Path("transfer.json"),
    resume: Annotated[bool, typer.Option("--resume", help="Go on with a run that was interrupted.")] = False,
    limit: Annotated[float, typer.Option(min=0.1, help="[s] of wall time that an episode may take.")] = 300.0,
) -> None:
    """Drive the same episodes on both, and print the ratio of success with its 95 % interval."""
    from threewe.benchmark.attempt import Settings
    from threewe.benchmark.bundle import text_of
    from threewe.benchmark.transfer import plan_transfer, run_transfer

    if task not in ("pointnav", "objectnav"):
        raise ConfigError(f"task: {task} has no success to compare")
    plan = plan_transfer(
        policy, source, target, task=task, split=split, scenes=scene or [], episodes=episodes, seeds=seeds,
        matched=matched, settings=Settings(),
    )  # fmt: skip
    journals = [output.with_suffix(f".{name}.jsonl") for name in ("source", "target")]
    if any(journal.exists() for journal in journals) and not resume:
        raise ConfigError(f"{journals[0]}: an interrupted run; --resume goes on with it, or remove it")
    try:
        with progress(f"{policy}, {source} to {target}", len(plan.on_source) + len(plan.on_target)) as advance:

            def done(_: int, __: int, ___: Any, finished: Any) -> None:
                advance(known=finished.known)

            found = run_transfer(plan, output, workers=workers, limit=limit, on_done=done)
    except KeyboardInterrupt:
        console.print(f"Interrupted: what has finished is in {journals[0]}; --resume goes on.")
        raise typer.Exit(130) from None
    output.write_bytes(text_of(found))
    for journal in journals:
        journal.unlink()
    _print(found)
    console.print(styled("result: ", (str(output), "bold")))


def _print(found: dict[str, Any]) -> None:
    figures = found["summary"]
    for name in ("source", "target"):
        figure = figures[name]
        interval = f"[{figure['low']:.2f}, {figure['high']:.2f}]"
        console.print(f"SR on {found[f'{name}_backend']}: {figure['value']:.2f} {interval} of {figure['count']}")
    ratio = figures["ratio"]
    if ratio is None:
        console.print("SR target / SR source: none, since nothing succeeded on the source")
    else:
        console.print(f"SR target / SR source: {ratio['value']:.2f} [{ratio['low']:.2f}, {ratio['high']:.2f}]")
