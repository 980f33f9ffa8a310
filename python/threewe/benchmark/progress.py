"""Progress of long commands, with the time left."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta

from rich.progress import BarColumn, Progress, TimeElapsedColumn

from threewe._console import plain_column, plain_console


@contextmanager
def progress(
    what: str, total: int | None, clock: Callable[[], float] = time.monotonic
) -> Iterator[Callable[..., None]]:
    """A bar on the error stream: calling what it gives advances it by one, or to `done` of `of`.

    The time left is what is to be done at the mean rate so far, however long each takes; one that was `known`, as from
    a journal, is done and took no time.
    """
    columns = (plain_column("{task.description}"), BarColumn(), plain_column("{task.completed:.0f}/{task.total}"))
    left = plain_column("{task.fields[left]}")
    begun, came = clock(), 0.0
    with Progress(*columns, TimeElapsedColumn(), left, console=plain_console(stderr=True)) as bars:
        bar = bars.add_task(what, total=total, left="")

        def advance(done: int | None = None, of: int | None = None, *, known: bool = False) -> None:
            nonlocal came, total
            before = bars.tasks[0].completed
            count, total = before + 1 if done is None else done, of or total
            came += 0 if known else count - before
            shown = "" if total is None or not came else time_left(total - count, (clock() - begun) / came)
            bars.update(bar, completed=count, total=total, left=shown)

        yield advance


def time_left(count: float, each: float) -> str:
    """In words, where so many take [s] each."""
    return f"{timedelta(seconds=round(count * each))} left"
