"""The commands `threewe slam ...`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, TimeElapsedColumn
from rich.progress import Progress as ProgressBar
from rich.table import Table

import threewe
from threewe._console import plain_column, plain_console, styled
from threewe._core import SlamConfig, log_names
from threewe.slam.formats import read_log
from threewe.slam.log import Progress
from threewe.slam.mapper import MEANING
from threewe.slam.relations import Accuracy, Relations
from threewe.slam.replay import Replay, replay
from threewe.slam.synth import synthesize

app = typer.Typer(
    help="Mapping on its own: from recorded logs, with how good the maps are.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
console = plain_console()


@app.command("replay")
def replay_log(
    log: Annotated[Path, typer.Argument(help="A CARMEN log, a journal of a recorder, or a rosbag2.")],
    relations: Annotated[
        Path | None, typer.Option(help="Pairs of places, t1 t2 x y z roll pitch yaw: the map's error is measured.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for the results; the log's name by default.")
    ] = None,
    range_max: Annotated[float, typer.Option(help="What a scan sees farther away is left out [m].")] = 30.0,
    resolution: Annotated[float, typer.Option(help="A cell of the map [m].")] = 0.05,
) -> None:
    """Map a log; leaves map.pgm, map.yaml, trajectory.tum and summary.json. Ends with 1 where a part is not mapped."""
    if not log.exists():
        raise threewe.ConfigError(f"{log}: no such log")
    known = Relations.read(relations) if relations else None
    with progress("reading") as tell:
        read = read_log(log, on_progress=tell)
    config = SlamConfig(base_from_lidar=read.base_from_lidar, range_max=range_max, resolution=resolution)
    with progress("mapping") as tell:
        result = replay(read, config, on_progress=tell)
    error = result.accuracy(known) if known else None
    folder = output or Path(log.stem)
    result.write(folder, error)
    console.print(table_of(result, error))
    console.print(styled("map.pgm, map.yaml, trajectory.tum and summary.json are in ", (f"{folder}/", "bold")))
    if result.outside:
        raise typer.Exit(1)


@app.command("synth")
def synthesize_logs(
    names: Annotated[
        list[str] | None, typer.Argument(help="Log specifications, or files that end in .yaml; all by default.")
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the logs.")] = Path(),
    seed: Annotated[int, typer.Option(min=0, max=2**64 - 1, help="Of all noise.")] = 0,
) -> None:
    """Record logs and relations like those of old robots, in the embedded simulator."""
    for name in names or log_names():
        with console.status(styled(f"driving {name}")):
            log, relations = synthesize(name, output, seed)
        console.print(styled((str(log), "bold"), " and ", (str(relations), "bold")), soft_wrap=True)


@contextmanager
def progress(what: str) -> Iterator[Progress]:
    """A bar in the terminal, while the work in the block says how far it is."""
    columns = plain_column("{task.description}"), BarColumn(), TimeElapsedColumn()
    with ProgressBar(*columns, console=console, transient=True) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)


def table_of(result: Replay, error: Accuracy | None) -> Table:
    """The figures worth a look."""
    log = result.log
    summary = result.summary()
    table = Table(show_header=False)
    table.add_row("scans", f"{len(log.scans)}, of {len(log.scans[0].ranges)} beams")
    for reason, count in log.skipped.items():
        table.add_row("skipped", f"{count} {reason}")
    if log.clock:
        table.add_row("times", log.clock)
    for event in result.events:
        scans = f"{event.scans} scans from {event.begin:.1f} to {event.end:.1f} s"
        table.add_row("noticed", f"{event.incident}, {scans}: {MEANING[event.incident]}")
    if result.outside:
        table.add_row("not mapped", f"{result.outside} scans: nothing relates them to the rest")
    table.add_row("driven", f"{summary['distance']:.1f} m in {log.seconds:.0f} s")
    table.add_row("loops closed", f"{summary['loop_closures']} times")
    table.add_row("computing", f"{result.computing_seconds:.2f} s: {summary['data_seconds_per_second']:.0f} data s/s")
    if error:
        table.add_row("error", str(error))
        if error.left_out:
            table.add_row("left out", f"{error.left_out} relations that the log does not reach")
    return table
