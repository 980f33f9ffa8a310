"""Where commands print: text as it is, in which no `[word]` is markup and no `:word:` an emoji."""

from __future__ import annotations

from rich.console import Console
from rich.progress import TextColumn
from rich.style import Style
from rich.text import Text


def plain_console(*, stderr: bool = False, width: int | None = None) -> Console:
    """A console that changes nothing in what it prints; as wide as the terminal where no `width` is given."""
    return Console(stderr=stderr, markup=False, emoji=False, width=width)


def plain_column(text: str) -> TextColumn:
    """A column of a progress bar with such text."""
    return TextColumn(text, markup=False)


def styled(*parts: str | tuple[str, str | Style]) -> Text:
    """Pieces of text, some of them with a style: `styled("saved to ", (path, "bold"))`."""
    return Text.assemble(*parts)
