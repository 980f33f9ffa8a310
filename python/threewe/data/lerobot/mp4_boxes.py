"""The boxes of an MP4 file (ISO/IEC 14496-12), as far as they say how much memory opening it would take."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from threewe.errors import ConfigError

CONTAINERS = {b"moov", b"trak", b"mdia", b"minf", b"stbl"}
COUNTED = {b"stsz": 8, b"stz2": 8, b"stts": 4, b"ctts": 4, b"stss": 4, b"stsc": 4, b"stco": 4, b"co64": 4, b"elst": 4}
"""Boxes with a number of entries, and where in their contents it stands."""
MOST_BOXES = 10_000


def check_mp4(path: Path, most_samples: int) -> None:
    """Raises ConfigError unless a file is an MP4 with tables of at most so many entries, all within the file.

    FFmpeg allocates what the tables announce before it reads a frame: some bytes can claim a billion of them.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(8)
        if len(head) < 8 or head[4:8] != b"ftyp":
            raise ConfigError(f"{path}: no MP4 file: it begins with {head!r}")
        names = set()
        for name, position, length in walk(path, file, 0, size, [0]):
            names.add(name)
            if name in (b"moof", b"mvex"):
                raise ConfigError(f"{path}: a fragmented MP4; LeRobot writes plain ones")
            if name in COUNTED:
                file.seek(position + COUNTED[name])
                field = file.read(4)
                count = struct.unpack(">I", field)[0] if len(field) == 4 and length >= COUNTED[name] + 4 else 2**32
                if count > most_samples:
                    raise ConfigError(f"{path}: {name.decode()} has {count} entries; expected at most {most_samples}")
        if b"moov" not in names or b"stsz" not in names:
            raise ConfigError(f"{path}: an MP4 without its tables: it was not written to the end")


def walk(path: Path, file: BinaryIO, begin: int, end: int, seen: list[int]) -> Iterator[tuple[bytes, int, int]]:
    """Type, place of contents and their length of each box, containers before what they contain."""
    while begin + 8 <= end:
        seen[0] += 1
        if seen[0] > MOST_BOXES:
            raise ConfigError(f"{path}: more than {MOST_BOXES} boxes")
        file.seek(begin)
        length, name = struct.unpack(">I4s", file.read(8))
        head = 8
        if length == 1:
            length, head = struct.unpack(">Q", file.read(8).ljust(8, b"\0"))[0], 16
        elif length == 0:
            length = end - begin
        if length < head or begin + length > end:
            raise ConfigError(
                f"{path}: box {name!r} of {length} bytes at {begin} reaches beyond the file: it is cut off"
            )
        yield name, begin + head, length - head
        if name in CONTAINERS:
            yield from walk(path, file, begin + head, begin + length, seen)
        begin += length
