"""The commands `threewe data info | validate | convert | merge | split | filter | append`: LeRobot datasets."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.progress import BarColumn, MofNCompleteColumn, TimeElapsedColumn
from rich.progress import Progress as ProgressBar
from rich.table import Table

from threewe._console import plain_column, plain_console, styled
from threewe.errors import ConfigError

if TYPE_CHECKING:
    from threewe.data.lerobot import Dataset
    from threewe.data.lerobot.editing import Progress

console = plain_console()

Folder = Annotated[Path, typer.Argument(help="Folder of a LeRobot dataset.")]
Sources = Annotated[list[Path], typer.Argument(help="Folders of LeRobot datasets.")]
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder of the new dataset, which must not exist.")]
Videos = Annotated[
    Literal["copy", "h264", "av1"], typer.Option(help="copy takes over what is encoded; the others encode anew.")
]


def info(dataset: Folder) -> None:
    """Show what a dataset holds: features, episodes, tasks."""
    from threewe.data.lerobot import Dataset

    console.print(table_of(Dataset.open(dataset)))


def validate(
    dataset: Folder,
    most: Annotated[int, typer.Option(min=1, help="So many problems are printed.")] = 20,
) -> None:
    """Check every row, statistic and frame of a dataset; ends with 1 where something is wrong."""
    from threewe.data.lerobot import validate as check

    with progress("checking") as tell:
        problems = check(dataset, on_progress=tell)
    for problem in problems[:most]:
        console.print(styled((problem.file, "bold"), str(problem)[len(problem.file) :]), soft_wrap=True)
    if len(problems) > most:
        console.print(f"and {len(problems) - most} more problems")
    if problems:
        raise typer.Exit(1)
    console.print(styled((str(dataset), "bold"), ": sound"), soft_wrap=True)


def convert(
    dataset: Folder,
    output: Output,
    version: Annotated[Literal["v3.0", "v2.1"], typer.Option(help="Of LeRobot's format.")] = "v3.0",
    codec: Videos = "copy",
) -> None:
    """Write a dataset in another version of the format, or with videos of another codec."""
    from threewe.data.lerobot import convert as write

    with progress("converting") as tell:
        made = write(dataset, output, version=version, codec=codec, on_progress=tell)
    tell_made(made)


def merge(datasets: Sources, output: Output, codec: Videos = "copy") -> None:
    """Make one dataset of several with the same features, rate and robot."""
    from threewe.data.lerobot import merge as write

    with progress("merging") as tell:
        made = write(datasets, output, codec=codec, on_progress=tell)
    tell_made(made)


def split(
    dataset: Folder,
    parts: Annotated[list[str], typer.Argument(help="NAME=SHARE, or NAME=EPISODES such as test=0,3,7-9.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the new datasets.")] = Path(),
    seed: Annotated[int | None, typer.Option(help="Shuffles the episodes before they are shared out.")] = None,
) -> None:
    """Share out the episodes of a dataset: `threewe data split my_dataset train=0.8 test=0.2`."""
    from threewe.data.lerobot import split as write

    wanted: dict[str | Path, float | list[int]] = {}
    for part in parts:
        name, equals, value = part.partition("=")
        if not equals or not name:
            raise ConfigError(f"{part!r}: a part is NAME=SHARE or NAME=EPISODES, such as train=0.8 or test=0,3,7-9")
        wanted[output / name] = share_or_episodes(value, part)
    with progress("splitting") as tell:
        made = write(dataset, wanted, seed=seed, on_progress=tell)
    for each in made:
        tell_made(each)


def filter_(
    dataset: Folder,
    output: Output,
    task: Annotated[list[str] | None, typer.Option(help="Episodes of this task; may be given again.")] = None,
    success: Annotated[bool | None, typer.Option(help="Those that succeeded, or those that did not.")] = None,
    min_length: Annotated[int, typer.Option(min=1, help="[frames]")] = 1,
    max_length: Annotated[int | None, typer.Option(min=1, help="[frames]")] = None,
    episodes: Annotated[str | None, typer.Option(help="Numbers, such as 0,3,7-9.")] = None,
) -> None:
    """Make a dataset of the episodes that fulfil all conditions."""
    from threewe.data.lerobot import filter_episodes

    with progress("filtering") as tell:
        made = filter_episodes(
            dataset,
            output,
            episodes=None if episodes is None else numbers(episodes),
            tasks=task or None,
            success=success,
            min_length=min_length,
            max_length=max_length,
            on_progress=tell,
        )
    tell_made(made)


def append(
    dataset: Folder,
    others: Annotated[list[Path], typer.Argument(help="Datasets whose episodes are added to it.")],
    codec: Videos = "copy",
) -> None:
    """Add the episodes of other datasets to one; until all are there it stays as it was."""
    from threewe.data.lerobot import append as write

    with progress("appending") as tell:
        made = write(dataset, others, codec=codec, on_progress=tell)
    tell_made(made)


def share_or_episodes(value: str, part: str) -> float | list[int]:
    """0.8, or the episodes of 0,3,7-9. Raises ConfigError."""
    try:
        return float(value) if "." in value or value == "1" else numbers(value)
    except ValueError:  # a ConfigError is one
        raise ConfigError(f"{part!r}: {value!r} is neither a share nor a list of episodes such as 0,3,7-9") from None


def numbers(text: str) -> list[int]:
    """Episodes of a list such as 0,3,7-9. Raises ConfigError."""
    found: list[int] = []
    for word in text.split(","):
        first, dash, last = word.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise ConfigError(f"{word!r} is no episode, nor a range such as 7-9")
        ends = int(first), int(last) if dash else int(first)
        if ends[1] - ends[0] > 10_000_000:
            raise ConfigError(f"{word!r}: no dataset has so many episodes")
        found += range(ends[0], ends[1] + 1)
    return found


@contextmanager
def progress(what: str) -> Iterator[Progress]:
    """A bar in the terminal that counts episodes."""
    columns = plain_column("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with ProgressBar(*columns, console=console, transient=True) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def tell_made(dataset: Dataset) -> None:
    """One line for a new dataset."""
    count, frames = len(dataset), dataset.info.total_frames
    seconds = frames / dataset.fps
    line = f": {count} episode{'s' * (count != 1)}, {frames} frames ({seconds:.0f} s), {dataset.version}"
    console.print(styled((str(dataset.root), "bold"), line), soft_wrap=True)


def table_of(dataset: Dataset) -> Table:
    """What a dataset holds."""
    lengths = [episode.length for episode in dataset.episodes]
    table = Table(show_header=False)
    table.add_row("format", f"LeRobot {dataset.version}")
    table.add_row("robot", dataset.info.robot_type or "not said")
    table.add_row("episodes", f"{len(lengths)}, of {min(lengths)} to {max(lengths)} frames")
    table.add_row("frames", f"{sum(lengths)} at {dataset.fps} Hz: {sum(lengths) / dataset.fps:.0f} s")
    for number, task in enumerate(dataset.tasks[:10]):
        count = sum(task in episode.tasks for episode in dataset.episodes)
        table.add_row(f"task {number}", styled(task, f" ({count} episode{'s' * (count != 1)})"))
    if len(dataset.tasks) > 10:
        table.add_row("", f"and {len(dataset.tasks) - 10} more tasks")
    for name, feature in dataset.own_features.items():
        codec = feature.info.get("video.codec", "")
        words = [feature.dtype, "x".join(map(str, feature.shape)), "depth" * feature.is_depth, str(codec)]
        named = ", ".join(map(str, feature.names)) if isinstance(feature.names, list) and not feature.is_camera else ""
        table.add_row(name, styled(" ".join(word for word in words if word), f"  {named}"[: 2 + len(named)]))
    return table
