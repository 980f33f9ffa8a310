"""Files of recorded steps: an episode grows in pieces that outlive its program, and becomes an .npz when it ends."""

from __future__ import annotations

import fcntl
import io
import os
import time
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np

from threewe._arguments import as_file
from threewe.errors import ConfigError, RecordingError

FINISHED, UNFINISHED = ".npz", ".steps"
MOST_STEPS = 50
"""That are not in the file yet, and ..."""
LONGEST = 1.0
"""[s] for which they wait for more."""
SIZES = np.dtype([("size", "<u4"), ("checksum", "<u4")])
"""Before each piece, which is an .npz itself."""

Columns = dict[str, Any]
"""Arrays by name."""


class StepFile:
    """An episode that is being recorded. While it is open, no other program takes it for one that was cut off.

    Args:
        folder: where it gets a number that no other episode has.
        task: what the agent is to do.
    """

    def __init__(self, folder: Path, task: str) -> None:
        self._path, self._file = _new_file(folder)
        self._rows: list[Mapping[str, Any]] = []
        self._since = time.monotonic()
        self._append({"task": np.array(task)})

    def add(self, row: Mapping[str, Any]) -> None:
        """A step: its values by name."""
        self._rows.append({name: np.array(value) for name, value in row.items()})
        if len(self._rows) >= MOST_STEPS or time.monotonic() - self._since >= LONGEST:
            self._write_rows()

    def finish(self) -> Path:
        """The finished episode."""
        self._write_rows()
        made = _finish(self._path)
        self.close()
        assert made.file is not None  # it has a step at least
        return made.file

    def close(self) -> None:
        """Leaves what is in the file as a program that dies would."""
        self._file.close()

    def _write_rows(self) -> None:
        if self._rows:
            self._append({name: np.stack([row[name] for row in self._rows]) for name in self._rows[0]})
        self._rows, self._since = [], time.monotonic()

    def _append(self, columns: Columns) -> None:
        """A piece, which outlives the program from here on."""
        content = io.BytesIO()
        np.savez_compressed(content, **columns)
        piece = content.getvalue()
        left = memoryview(np.array((len(piece), zlib.crc32(piece)), SIZES).tobytes() + piece)
        begin = self._file.tell()
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError as error:
            self._file.truncate(begin)  # the same steps can be tried again behind what is whole
            self._file.seek(begin)
            raise RecordingError(f"cannot write {self._path}: {error.strerror}") from None


def finished(folder: Path) -> list[Path]:
    """The episodes of a folder, by their numbers."""
    return sorted(folder.glob(f"episode_[0-9]*{FINISHED}"), key=_number)


def unfinished(folder: Path) -> list[Path]:
    """Those that are being recorded, or were when their program died."""
    return sorted(folder.glob(f"episode_[0-9]*{UNFINISHED}"), key=_number)


class RecoveredSteps(NamedTuple):
    """What was made of an episode that was cut off."""

    file: Path | None  # None where nothing of it could be saved
    steps: int


def recover_steps(folder: str | os.PathLike[str]) -> list[RecoveredSteps]:
    """Finishes the episodes of steps in a folder that were cut off, but for those that are being recorded."""
    found = []
    for path in unfinished(as_file("folder", folder)):
        with path.open("rb") as file:
            if _lock(file):
                found.append(_finish(path))
    return found


def read_steps(file: Path) -> Columns:
    """What a finished episode has. Raises ConfigError where it is none."""
    try:
        with np.load(file, allow_pickle=False) as arrays:
            return dict(arrays)
    except (OSError, ValueError, EOFError, KeyError) as error:
        raise ConfigError(f"{file}: no episode: {error}") from None


def _number(path: Path) -> int:
    digits = path.stem.removeprefix("episode_")
    return int(digits) if digits.isdecimal() else -1


def _lock(file: IO[bytes] | io.FileIO) -> bool:
    """Whether no other program has it open for recording."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _new_file(folder: Path) -> tuple[Path, io.FileIO]:
    """The next one. Others may record into the same folder. Raises ConfigError."""
    number = 1 + max(map(_number, (*finished(folder), *unfinished(folder))), default=-1)
    while True:
        path = folder / f"episode_{number:06d}{UNFINISHED}"
        try:
            file = path.open("xb", buffering=0)
        except FileExistsError:
            number += 1
            continue
        except OSError as error:
            raise ConfigError(f"{path}: cannot be written: {error.strerror}") from None
        _lock(file)
        return path, file


def _finish(path: Path) -> RecoveredSteps:
    """Puts the sound pieces of an episode together, synchronized before they get their name."""
    [head, *pieces] = _pieces(path) or [{}]
    if not pieces:
        path.unlink()
        return RecoveredSteps(None, 0)
    columns: Columns = {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}
    made, beside = path.with_suffix(FINISHED), path.with_suffix(".tmp")
    with beside.open("wb") as file:
        np.savez_compressed(file, **head | columns)
        file.flush()
        os.fsync(file.fileno())
    beside.rename(made)
    path.unlink()
    return RecoveredSteps(made, len(columns["action"]))


def _pieces(path: Path) -> list[Columns]:
    """All up to the first that is torn."""
    content, at, found = path.read_bytes(), 0, []
    while at + SIZES.itemsize <= len(content):
        size, checksum = np.frombuffer(content, SIZES, 1, at)[0].tolist()
        at += SIZES.itemsize
        piece = content[at : at + size]
        if not size or len(piece) < size or zlib.crc32(piece) != checksum:
            break
        with np.load(io.BytesIO(piece), allow_pickle=False) as arrays:
            found.append(dict(arrays))
        at += size
    return found
