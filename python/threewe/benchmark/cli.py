"""`threewe benchmark`: agents through tasks, results that can be compared, shown and replayed."""

from __future__ import annotations

from dataclasses import replace
from enum import Enum
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import typer
from rich.box import SIMPLE
from rich.table import Column, Table

from threewe._console import plain_console, styled
from threewe.benchmark import cli_episodes, cli_submission
from threewe.benchmark.progress import progress
from threewe.errors import ConfigError

app = typer.Typer(
    help="Benchmarks: PointNav, ObjectNav, VLN and Exploration, with results that anyone can replay.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.add_typer(cli_episodes.app, name="episodes")
for command in (cli_submission.login, cli_submission.submit):
    app.command()(command)
console = plain_console()
WIDE = 150  # characters of a table that goes to a file


class Engine(Enum):
    """Where processes run."""

    local = "local"
    ray = "ray"


Workers = Annotated[int, typer.Option(min=1, help="Processes at a time; results are the same for any number.")]
SHOWN = {
    "success": "SR",
    "success_without_contact": "no contact",
    "spl": "SPL",
    "soft_spl": "SoftSPL",
    "contacts": "contacts",
    "duration": "time [s]",
    "distance_to_success": "left [m]",
    "coverage": "coverage",
    "cell_ratio": "cell ratio",
    "map_accuracy": "map accuracy",
    "agent_failures": "agent failed",
}


@app.command()
def run(
    task: Annotated[str, typer.Argument(help="pointnav, objectnav, vln or exploration.")],
    agent: Annotated[
        str,
        typer.Option(
            help="Shipped (navigator, vlm@ADDRESS, ...), policy:FOLDER, module:Class, FILE.onnx or .safetensors."
        ),
    ] = "navigator",
    episodes: Annotated[int, typer.Option(min=1, help="So many of each scene.")] = 50,
    scene: Annotated[
        list[str] | None, typer.Option(help="A scene, more than once for several; all of the set.")
    ] = None,
    split: Annotated[str, typer.Option(help="val, test, or a set of episodes by name or file.")] = "val",
    workers: Workers = 1,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Results; TASK-AGENT.json by default.")] = None,
    bundle: Annotated[Path | None, typer.Option(help="All that a replay needs, as one .zip.")] = None,
    submit: Annotated[
        bool, typer.Option("--submit", help="Send the bundle to where `login` said; OUTPUT.zip without --bundle.")
    ] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with a run that was interrupted.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Of the agent's own choices.")] = 0,
    control_rate: Annotated[float, typer.Option(min=1.0, help="[Hz] of agents that act.")] = 10.0,
    backend: Annotated[str, typer.Option(help="Where the robot is.")] = "mock",
    hardware: Annotated[str, typer.Option(help="Which robot. Official results have the default.")] = "3we_standard_v2",
    noise: Annotated[str, typer.Option(help="realistic or ideal. Official results have the default.")] = "realistic",
    randomization: Annotated[str, typer.Option(help="Of the robot. Official results have the default.")] = "none",
    engine: Annotated[Engine, typer.Option(help="Processes of this machine, or of a Ray cluster.")] = Engine.local,
    address: Annotated[str | None, typer.Option(help="Of the Ray cluster; one is started here without.")] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="All at once in the native batch, for agents that act; never official.")
    ] = False,
    compact: Annotated[
        bool, typer.Option("--compact", help="Leave trajectories out of the results, which a report needs.")
    ] = False,
    limit: Annotated[float, typer.Option(min=0.1, help="[s] of wall time that an episode may take.")] = 120.0,
    memory: Annotated[float, typer.Option(min=0.25, help="[GiB] that the agent's process may use.")] = 4.0,
) -> None:
    """Drive an agent through the episodes of a task. Ctrl-C keeps what has finished, and --resume goes on."""
    from threewe.benchmark.attempt import Settings
    from threewe.benchmark.run import plan_run

    settings = Settings(hardware, backend, noise, randomization, control_rate, seed)
    plan, listed = plan_run(task, agent, split=split, scenes=scene or [], episodes=episodes, settings=settings)
    path = output or Path(f"{task}-{Path(agent.partition('@')[0]).stem.replace(':', '.')}.json")
    bundle = bundle or (path.with_suffix(".zip") if submit else None)
    if bundle and (quick or plan.agent.kind == "yardstick"):
        raise ConfigError("bundle: neither a quick run nor a baseline has a log that could be replayed")
    if quick:
        _run_quick(replace(plan, quick=True), listed, path, workers, compact)
        return
    journal = path.with_suffix(".journal.jsonl")
    if journal.exists() and not resume:
        raise ConfigError(f"{journal}: an interrupted run; --resume goes on with it, or remove it")
    how = {"workers": workers, "limit": limit, "memory": int(memory * 2**30)}
    outcomes = _drive(plan, listed, journal, **how, engine=engine.value, address=address)
    _write(plan, listed, outcomes, path, bundle, compact)
    journal.unlink()
    if bundle and submit:
        cli_submission.submit_or_keep(bundle)


def _drive(plan: Any, listed: Any, journal: Path, **how: Any) -> list[Any]:
    """The episodes, with their progress and what agents failed of."""
    from threewe.benchmark.run import run as run_episodes

    failures: list[str] = []
    try:
        with progress(f"{plan.task}, {plan.agent.name}", len(listed)) as advance:

            def done(_: int, __: int, episode: Any, finished: Any) -> None:
                advance(known=finished.known)
                why = finished.failure or finished.result["failure"]
                if why:
                    failures.append(f"{episode.scene}/{episode.index}: the agent failed: {why.splitlines()[-1]}")

            outcomes = run_episodes(plan, listed, journal, **how, on_done=done)
    except KeyboardInterrupt:
        console.print(f"Interrupted: what has finished is in {journal}; --resume goes on.")
        raise typer.Exit(130) from None
    for line in sorted(failures):
        console.print(line)
    return outcomes


def _write(plan: Any, listed: Any, outcomes: list[Any], path: Path, bundle: Path | None, compact: bool) -> None:
    from threewe.benchmark.bundle import text_of, write_bundle
    from threewe.benchmark.results import without_trajectories
    from threewe.benchmark.run import results_of

    results = results_of(plan, listed, outcomes)
    path.write_bytes(text_of(without_trajectories(results) if compact else results))
    if bundle:
        write_bundle(bundle, results, outcomes)
    _print_summary(results)
    console.print(styled("results: ", (str(path), "bold"), *((f", bundle: {bundle}",) if bundle else ())))


def _run_quick(plan: Any, listed: Any, path: Path, threads: int, compact: bool) -> None:
    from threewe.benchmark.quick import run_quick

    _write(plan, listed, run_quick(plan, listed, threads=threads), path, None, compact)


@app.command()
def show(
    results: Annotated[Path, typer.Argument(help="Results, or a bundle.")],
    page: Annotated[
        Path | None, typer.Option("--html", help="Also write a page with plots, trajectories and a player.")
    ] = None,
) -> None:
    """Print the figures of a run, with their 95 % intervals."""
    from threewe.benchmark.results import load_results

    found = load_results(results)
    _print_summary(found)
    if page:
        from threewe.benchmark.report import write_report

        write_report(found, page)
        console.print(styled("page: ", (str(page), "bold")))


@app.command()
def table(
    results: Annotated[list[Path], typer.Argument(help="Results, or folders of them.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="The page; printed where left out.")] = None,
) -> None:
    """Make one page of several results, as Markdown: agents next to one another, with 95 % intervals."""
    from threewe.benchmark.table import find_results, page

    text = page(find_results(results), output.parent if output else Path())
    if output is None:
        typer.echo(text, nl=False)
        return
    output.write_text(text)
    console.print(styled("page: ", (str(output), "bold")))


@app.command()
def compare(
    first: Annotated[Path, typer.Argument(help="Results, or a bundle.")],
    second: Annotated[Path, typer.Argument(help="Others, on the same set of episodes.")],
) -> None:
    """Print the paired differences of two runs, second less first, with their 95 % intervals."""
    from threewe.benchmark.results import compare as compare_results
    from threewe.benchmark.results import load_results

    one, other = load_results(first), load_results(second)
    table = Table("metric", one["agent"]["name"], other["agent"]["name"], "difference", "95 %", "episodes")
    for name, figure in compare_results(one, other).items():
        values = [f"{some['summary']['all'][name]['value']:.3f}" for some in (one, other)]
        interval = f"[{figure['low']:+.3f}, {figure['high']:+.3f}]"
        table.add_row(SHOWN.get(name, name), *values, f"{figure['value']:+.3f}", interval, str(figure["count"]))
    console.print(table)


@app.command()
def verify(
    bundle: Annotated[Path, typer.Argument(help="What `run --bundle` wrote.")],
    workers: Workers = 1,
    episode_file: Annotated[
        Path | None, typer.Option("--episodes", help="The set of episodes, where it is not one that comes with 3we.")
    ] = None,
    talk: Annotated[
        bool, typer.Option("--talk", help="Also repeat conversations with a model, without its server.")
    ] = False,
    rerun_policy: Annotated[
        bool, typer.Option("--rerun-policy", help="Also drive the agent through new buildings. It runs its code.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Of the new buildings.")] = 0,
    new_episodes: Annotated[int, typer.Option(min=1, help="So many of them.")] = 20,
) -> None:
    """Replay every episode of a bundle below the gate, and compare to the bit."""
    from threewe.benchmark.bundle import BundleError
    from threewe.benchmark.verifying import rerun_policy as rerun
    from threewe.benchmark.verifying import verify_bundle

    try:
        with progress("replay", None) as advance:
            verified = verify_bundle(
                bundle,
                workers=workers,
                episode_file=episode_file,
                talk=talk,
                on_done=lambda done, of: advance(done, of),
            )
    except BundleError as error:
        console.print(styled(("refused: ", "bold red"), str(error)))
        raise typer.Exit(1) from None
    count = len(verified.results["episode_results"])
    console.print(styled(("verified", "bold green"), f": {count} episodes replay to the bit, track open"))
    _print_summary(verified.results)
    if rerun_policy:
        with TemporaryDirectory() as folder, progress("new buildings", new_episodes) as advance:
            again = rerun(
                verified,
                seed=seed,
                episodes=new_episodes,
                workers=workers,
                folder=Path(folder),
                on_done=lambda *_: advance(),
            )
        again["summary"] = {"all": again["summary"]["all"]}
        console.print(f"the same policy in {new_episodes} new buildings of seed {seed}:")
        _print_summary(again)


def _print_summary(results: dict[str, Any]) -> None:
    """A row for each scene."""
    agent, settings = results["agent"], results["settings"]
    marks = (
        ["privileged"] * agent["privileged"]
        + ["not official"] * (not results["official"])
        + ["quick"] * results["quick"]
    )
    title = f"{results['task']}, {agent['name']}{''.join(f', {mark}' for mark in marks)}"
    names = [name for name in SHOWN if name in results["summary"]["all"]]
    columns = [Column(SHOWN[name], justify="right", no_wrap=True) for name in names]
    table = Table("scene", "n", *columns, title=title, box=SIMPLE, padding=(0, 1, 0, 0))
    for scene, figures in results["summary"].items():
        cells = [_cell(name, figures[name]) for name in names]
        table.add_row(scene, str(figures[names[0]]["count"]), *cells)
    wide = console if console.is_terminal else plain_console(width=WIDE)
    wide.print(table)
    wide.print(
        f"{results['episode_set']}, {settings['backend']}, {settings['hardware']}, noise {settings['noise']}, "
        f"gate {results['gate']}, localization {results['localization']}, randomization {settings['randomization']}, "
        f"repeats {results['repeats']}"
    )


def _cell(name: str, figure: dict[str, Any]) -> str:
    if name == "agent_failures":
        return f"{figure['value']:g}"
    digits = 0 if name == "duration" else 2
    value, low, high = (f"{figure[key]:.{digits}f}" for key in ("value", "low", "high"))
    return f"{value}\n{low} to {high}"
