"""The commands `threewe data push` and `threewe data pull`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TaskProgressColumn, TimeRemainingColumn

from threewe._console import plain_column, plain_console, styled

console = plain_console()


def push(
    dataset: Annotated[Path, typer.Argument(help="The folder of a LeRobot dataset.")],
    repo_id: Annotated[str, typer.Option(help="Where to: user/name.")],
    private: Annotated[bool, typer.Option("--private", help="Only you can see it.")] = False,
    license: Annotated[str | None, typer.Option(help="For the card: cc-by-4.0, apache-2.0 ...")] = None,
) -> None:
    """Publish a dataset on the Hugging Face Hub. Broken off, it goes on where it was when you push again.

    The token is the one of `hf auth login`, or of HF_TOKEN.
    """
    from threewe.data import hub

    url = hub.push(dataset, repo_id, private=private, license=license)
    console.print(styled("pushed to ", (url, "bold")), soft_wrap=True)


def pull(
    repo_id: Annotated[str, typer.Argument(help="Which one: user/name.")],
    directory: Annotated[Path, typer.Argument(help="A new folder for it.")],
    revision: Annotated[str | None, typer.Option(help="Branch, tag or commit; v3.0 by default.")] = None,
) -> None:
    """Download a dataset from the Hugging Face Hub, and check that it is whole."""
    from threewe.data import hub

    columns = plain_column("{task.description}"), BarColumn(), TaskProgressColumn(markup=False), TimeRemainingColumn()
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(f"pulling {repo_id}", total=1.0)
        folder = hub.pull(
            repo_id, directory, revision=revision, on_progress=lambda share: bar.update(task, completed=share)
        )
    console.print(styled("pulled to ", (str(folder), "bold")), soft_wrap=True)
