"""Files of a dataset in place of which something else lies: links, pipes, bombs, videos that are none."""

from __future__ import annotations

import os
import random
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

Attack = Callable[[Path, random.Random], None]
INFO, TASKS, STATS = "meta/info.json", "meta/tasks.parquet", "meta/stats.json"
EPISODES = "meta/episodes/chunk-000/file-000.parquet"
DATA = "data/chunk-000/file-000.parquet"
VIDEO = "videos/observation.images.front/chunk-000/file-000.mp4"
ALL = (INFO, TASKS, STATS, EPISODES, DATA, VIDEO)


def link_out(file: str) -> Attack:
    """A link to a file outside."""

    def attack(root: Path, _: random.Random) -> None:
        elsewhere = root.parent.parent / "outside" / Path(file).name
        (root / file).rename(elsewhere)
        (root / file).symlink_to(elsewhere)

    return attack


def link_to(file: str, target: str) -> Attack:
    """A link to something of the system."""

    def attack(root: Path, _: random.Random) -> None:
        (root / file).unlink()
        (root / file).symlink_to(target)

    return attack


def link_folder(folder: str) -> Attack:
    """A folder that is a link to one outside."""

    def attack(root: Path, _: random.Random) -> None:
        elsewhere = root.parent.parent / "outside" / "folder"
        (root / folder).rename(elsewhere)
        (root / folder).symlink_to(elsewhere)

    return attack


def pipe(file: str) -> Attack:
    """A pipe, at which a reader waits for ever."""

    def attack(root: Path, _: random.Random) -> None:
        (root / file).unlink()
        os.mkfifo(root / file)

    return attack


def folder(file: str) -> Attack:
    """A folder instead of a file."""

    def attack(root: Path, _: random.Random) -> None:
        (root / file).unlink()
        (root / file).mkdir()

    return attack


def content(file: str, *parts: bytes) -> Attack:
    """Another content."""

    def attack(root: Path, _: random.Random) -> None:
        (root / file).write_bytes(b"".join(parts))

    return attack


def remove(file: str) -> Attack:
    """No such file."""

    def attack(root: Path, _: random.Random) -> None:
        (root / file).unlink()

    return attack


def sparse(file: str, size: int) -> Attack:
    """A file that claims to be large, and takes no room."""

    def attack(root: Path, _: random.Random) -> None:
        os.truncate(root / file, size)

    return attack


def patch_box(name: bytes, offset: int, value: bytes) -> Attack:
    """Other numbers in a box of the video; `offset` is counted from its name."""

    def attack(root: Path, _: random.Random) -> None:
        data = bytearray((root / VIDEO).read_bytes())
        place = data.index(name, data.index(b"moov") - 4) + offset
        data[place : place + len(value)] = value
        (root / VIDEO).write_bytes(data)

    return attack


def other_video(codec: str, size: tuple[int, int], frames: int, container: str = "mp4", fps: int = 10) -> Attack:
    """A video of another size, length, codec or container."""

    def attack(root: Path, _: random.Random) -> None:
        import av

        with av.open(str(root / VIDEO), "w", format=container) as output:
            stream: Any = output.add_stream(codec, fps)
            stream.height, stream.width = size
            stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
            for i in range(frames):
                image = np.full((*size, 3), 10 * i % 256, np.uint8)
                output.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
            output.mux(stream.encode(None))

    return attack


def no_picture(root: Path, _: random.Random) -> None:
    """A file with sound alone."""
    import av

    with av.open(str(root / VIDEO), "w", format="mp4") as output:
        stream = output.add_stream("aac", rate=8000, layout="mono")
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), format="fltp", layout="mono")
        frame.sample_rate = 8000
        output.mux(stream.encode(frame))
        output.mux(stream.encode(None))


def header_of_another(root: Path, rng: random.Random) -> None:
    """The tables say 64x48, the stream itself 4096x2304: a decoder would make room for that."""
    other_video("libx264", (2304, 4096), 3)(root, rng)
    data = bytearray((root / VIDEO).read_bytes())
    place = data.index(b"avc1", data.index(b"stsd")) + 28
    data[place : place + 4] = struct.pack(">HH", 64, 48)
    (root / VIDEO).write_bytes(data)


DEEP = b"[" * 200_000
PLAYLIST = b"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nfile:///etc/passwd\n#EXT-X-ENDLIST\n"
CONCAT = b"ffconcat version 1.0\nfile '/etc/passwd'\n"
PICKLE = b"\x80\x04\x95\x1d\x00\x00\x00\x00\x00\x00\x00\x8c\x05posix\x8c\x06system\x93\x8c\x02id\x85R."
HUGE = struct.pack(">I", 0xFFFFFFF0)

FILES: dict[str, Attack] = {
    **{f"link out of it: {file}": link_out(file) for file in ALL},
    **{f"link to /dev/zero: {file}": link_to(file, "/dev/zero") for file in ALL},
    **{f"link to /etc/passwd: {file}": link_to(file, "/etc/passwd") for file in (INFO, DATA, VIDEO)},
    **{f"link to itself: {file}": link_to(file, Path(file).name) for file in (INFO, DATA, VIDEO)},
    **{f"folder that is a link: {name}": link_folder(name) for name in ("data", "meta/episodes", "videos", "meta")},
    **{f"pipe: {file}": pipe(file) for file in ALL},
    **{f"folder: {file}": folder(file) for file in ALL},
    **{f"empty: {file}": content(file) for file in ALL},
    **{f"missing: {file}": remove(file) for file in ALL},
    **{f"text: {file}": content(file, b"hello\n" * 100) for file in ALL},
    **{f"a pickle: {file}": content(file, PICKLE) for file in ALL},
    **{f"deep JSON: {file}": content(file, DEEP) for file in (INFO, STATS)},
    "JSON with NaN": content(STATS, b'{"action": {"min": [NaN], "max": [1], "mean": [0], "std": [1], "count": [24]}}'),
    "JSON with infinity": content(
        STATS, b'{"action": {"min": [-Infinity], "max": [1], "mean": [0], "std": [1], "count": [1]}}'
    ),
    "JSON with 1e999": content(
        STATS, b'{"action": {"min": [1e999], "max": [1], "mean": [0], "std": [1], "count": [1]}}'
    ),
    "statistics of texts": content(
        STATS, b'{"action": {"min": ["a"], "max": [1], "mean": [0], "std": [1], "count": [1]}}'
    ),
    "statistics of no feature": content(
        STATS, b'{"none": {"min": [0], "max": [1], "mean": [0], "std": [1], "count": [1]}}'
    ),
    "statistics: a list": content(STATS, b"[1, 2]"),
    "info: a list": content(INFO, b"[]"),
    "info: a number of 5000 digits": content(INFO, b'{"fps": ' + b"9" * 5000 + b"}"),
    "info: not UTF-8": content(INFO, b'{"fps": "\xff\xfe"}'),
    "info: sparse, a gigabyte": sparse(INFO, 2**30),
    "table: sparse, 100 GB": sparse(DATA, 100 * 2**30),
    "video: a playlist": content(VIDEO, PLAYLIST),
    "video: a list of files": content(VIDEO, CONCAT),
    "video: a playlist behind a head": content(VIDEO, b"\0\0\0\x10ftypisom\0\0\0\0", PLAYLIST),
    "video: only a head": content(VIDEO, b"\0\0\0\x10ftypisom\0\0\0\0"),
    "video: a billion samples": patch_box(b"stsz", 12, HUGE),
    "video: a billion equal samples": patch_box(b"stsz", 8, struct.pack(">II", 1, 0xFFFFFFF0)),
    "video: a billion times": patch_box(b"stts", 8, HUGE),
    "video: a billion chunks": patch_box(b"stco", 8, HUGE),
    "video: a table beyond its end": patch_box(b"moov", -4, HUGE),
    "video: a table of no length": patch_box(b"trak", -4, struct.pack(">I", 1)),
    "video: another codec by its name": patch_box(b"avc1", 0, b"evil"),
    "video: larger frames": other_video("libx264", (96, 128), 24),
    "video: 4096x2304": other_video("libx264", (2304, 4096), 3),
    "video: larger in its stream than in its head": header_of_another,
    "video: fewer frames": other_video("libx264", (48, 64), 7),
    "video: another rate": other_video("libx264", (48, 64), 24, fps=7),
    "video: Matroska": other_video("libx264", (48, 64), 24, "matroska"),
    "video: MJPEG": other_video("mjpeg", (48, 64), 24),
    "video: no picture": no_picture,
}
