"""Faults of one token: drawn from all sources of a module, so that each line is as likely."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

SWAPS = [
    (" < ", " <= "),
    (" <= ", " < "),
    (" > ", " >= "),
    (" >= ", " > "),
    (" == ", " != "),
    (" != ", " == "),
    (" + ", " - "),
    (" - ", " + "),
    (" * ", " / "),
    (" && ", " || "),
    (" || ", " && "),
    (" += ", " -= "),
    (" -= ", " += "),
    ("std::min(", "std::max("),
    ("std::max(", "std::min("),
    ("std::sin(", "std::cos("),
    ("exact::sin(", "exact::cos("),
    ("return true;", "return false;"),
    ("return false;", "return true;"),
    ("if (!", "if ("),
    ("continue;", "break;"),
]
"""What takes the place of what."""
NUMBER = re.compile(r"(?<![\w.])\d+\.\d+(?![\w.])")
LEFT_OUT = ("#", "//", "static_assert", "namespace", "template", "using", "throw")


@dataclass(frozen=True)
class Fault:
    """One line of a source that becomes another."""

    file: str
    line: int
    before: str
    after: str

    def __str__(self) -> str:
        """Where it is, and what it does."""
        return f"{self.file}:{self.line}: {self.before.strip()}  ->  {self.after.strip()}"

    def plant(self, root: Path) -> None:
        """Puts it into a tree."""
        self._exchange(root, self.before, self.after)

    def remove(self, root: Path) -> None:
        """Takes it out again."""
        self._exchange(root, self.after, self.before)

    def _exchange(self, root: Path, old: str, new: str) -> None:
        path = root / self.file
        lines = path.read_text().splitlines(keepends=True)
        assert lines[self.line - 1].rstrip("\n") == old, f"{path}:{self.line} is another line"
        lines[self.line - 1] = new + "\n"
        path.write_text("".join(lines))


def draw(root: Path, module: str, draws: random.Random) -> Fault:
    """Draws a fault of a module."""
    path, number, line = draws.choice(lines_of(root, module))
    return Fault(path.relative_to(root).as_posix(), number, line, draws.choice(list(changes(line))))


def lines_of(root: Path, module: str) -> list[tuple[Path, int, str]]:
    """The lines of a module's sources, by file and number, in which there can be a fault."""
    sources = [path for path in sorted((root / "src" / module).rglob("*.[ch]pp")) if not path.name.endswith("-inl.hpp")]
    return [
        (path, number, line)
        for path in sources
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if not line.strip().startswith(LEFT_OUT) and any(True for _ in changes(line))
    ]


def changes(line: str) -> Iterator[str]:
    """Yields what one token of a line can become; comments and strings stay as they are."""
    code = line.partition("//")[0]
    if '"' in code:
        return
    rest = line[len(code) :]
    for old, new in SWAPS:
        at = code.find(old)
        while at >= 0:
            yield code[:at] + new + code[at + len(old) :] + rest
            at = code.find(old, at + 1)
    for match in NUMBER.finditer(code):
        if float(match[0]) != 0.0:
            yield f"{code[: match.start()]}{2.0 * float(match[0])!r}{code[match.end() :]}{rest}"
