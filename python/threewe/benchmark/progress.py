"""Progress of long commands, with the time left."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, TimeElapsedColumn, TimeRemainingColumn

from threewe._console import plain_column, plain_console


@contextmanager
def progress(what: str, total: int | None) -> Iterator[Callable[..., None]]:
    """A bar on the error stream: calling what it gives advances it by one, or to `done` of `total`."""
    columns = (plain_column(what), BarColumn(), plain_column("{task.completed}/{task.total}"))
    with Progress(*columns, TimeElapsedColumn(), TimeRemainingColumn(), console=plain_console(stderr=True)) as bars:
        bar = bars.add_task(what, total=total)

        def advance(done: int | None = None, of: int | None = None) -> None:
            if done is None:
                bars.advance(bar)
            else:
                bars.update(bar, completed=done, total=of)

        yield advance
