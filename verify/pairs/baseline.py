"""The baseline: `verify/baseline/<set>.jsonl`, a first line that says of what, then a line for each drive."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import threewe

from verify.pairs.outcomes import Outcome

FOLDER = Path(__file__).resolve().parents[1] / "baseline"
FORMAT = "threewe-pairs/1"
FIELDS = {"reason": str, "success": bool, "seconds": float, "metres": float, "hash": str}
RENEW = "./dev pairs --renew makes it anew"


class BaselineError(Exception):
    """A baseline that cannot be compared with: where, what is wrong, what would be right."""


def read(name: str, drives: list[str] | None = None, folder: Path = FOLDER) -> dict[str, Outcome]:
    """Returns the outcomes on file of a set, which must be of these drives where they are named.

    Raises BaselineError for a file that is missing, of another format or release, damaged, or of other drives.
    """
    path = folder / f"{name}.jsonl"
    if not path.exists():
        raise BaselineError(f"{path}: there is no baseline of {name}; {RENEW}")
    lines = path.read_text().splitlines()
    head = parsed(path, 1, lines[0] if lines else "")
    if head.get("format") != FORMAT:
        raise BaselineError(f"{path}:1: the format is {head.get('format')!r}, not {FORMAT!r}; {RENEW}")
    if head.get("release") != threewe.__version__:
        raise BaselineError(f"{path}:1: of release {head.get('release')}, and this is {threewe.__version__}; {RENEW}")
    found: dict[str, Outcome] = {}
    for number, line in enumerate(lines[1:], 2):
        entry = parsed(path, number, line)
        drive = entry.pop("drive", None)
        if not isinstance(drive, str) or not is_outcome(entry):
            raise BaselineError(f"{path}:{number}: expected drive, {', '.join(FIELDS)}; got {line[:80]!r}; {RENEW}")
        found[drive] = entry
    if drives is None:
        return found
    if missing := [drive for drive in drives if drive not in found]:
        raise BaselineError(f"{path}: {listed(missing)} missing; {RENEW}")
    if unknown := sorted(set(found) - set(drives)):
        raise BaselineError(f"{path}: {listed(unknown)} unknown to verify/pairs/drives.py; {RENEW}")
    return found


def write(name: str, outcomes: Mapping[str, Outcome], folder: Path = FOLDER) -> None:
    """Writes a set, one drive a line, so that a diff shows which drives changed."""
    folder.mkdir(parents=True, exist_ok=True)
    head = {"format": FORMAT, "release": threewe.__version__}
    lines = [head, *({"drive": drive, **outcomes[drive]} for drive in outcomes)]
    unfinished = folder / f".{name}.jsonl"
    unfinished.write_text("".join(json.dumps(line) + "\n" for line in lines))
    unfinished.replace(folder / f"{name}.jsonl")


def parsed(path: Path, number: int, line: str) -> Outcome:
    """Returns the object on one line."""
    try:
        entry = json.loads(line)
    except ValueError:
        entry = None
    if not isinstance(entry, dict):
        raise BaselineError(f"{path}:{number}: expected an object of JSON, got {line[:80]!r}; {RENEW}")
    return entry


def is_outcome(entry: Outcome) -> bool:
    """Whether all fields are there, and no others."""
    return entry.keys() == FIELDS.keys() and all(isinstance(entry[name], kind) for name, kind in FIELDS.items())


def listed(drives: list[str], most: int = 3) -> str:
    """Returns the first few names, and how many more there are."""
    more = f" and {len(drives) - most} more" if len(drives) > most else ""
    return ", ".join(drives[:most]) + more + (" is" if len(drives) == 1 else " are")
