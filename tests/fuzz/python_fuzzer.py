"""Coverage-guided fuzzing of the formats that are read in Python: `python -m tests.fuzz.python_fuzzer FORMAT`.

Inputs grow out of the seeds in corpus/<format>/: one that reaches a line which none before has reached is kept, and
changed further. A child process reads; its parent notices when it dies, hangs or takes too much memory.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import random
import resource
import shutil
import signal
import struct
import sys
import tempfile
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from types import FrameType
from typing import Any

CORPUS = Path(__file__).parent / "corpus"
TIME_LIMIT = 5.0  # [s] of computing for one input ...
WALL_LIMIT = 120.0  # [s] ... which others may keep waiting
FREE_MEMORY = 2**30  # [bytes] beside 64 for each byte of input: two maps of 16.7 million cells
MEMORY_PER_BYTE = 64
LARGEST = 2**18  # [bytes] of an input
REPLAYED = 4  # scans of a log that are mapped

EXTREMES = (
    b"0 -0.0 1 -1 nan inf -inf 1e308 -1e308 1e-320 1e400 1e6 -1000000 1000001 16384 16385 65536 2147483647 2147483648 "
    b"4294967296 9223372036854775808 18446744073709551616 0.001 3.14159 1e9 1e-9 true null {} [] \xff\xfe \x00 "
    b"99999999999999999999999999999999999999999999999999999999999999999999999999999999"
).split()

NUMBERS = (0.0, -1.0, 1e6, -1e7, 1e9, 1e18, -1e30, 5e-324, 1e308, math.nan, math.inf, -math.inf)
BINARY = (
    *(struct.pack("<d", number) for number in NUMBERS),
    *(struct.pack("<f", number) for number in NUMBERS if not 1e30 < abs(number) < math.inf),
    *(struct.pack("<I", number) for number in (0, 1, 255, 65536, 2**31 - 1, 2**31, 2**32 - 1)),
    *(struct.pack("<Q", number) for number in (2**32, 2**53, 2**63 - 1, 2**63, 2**64 - 1)),
)


def read_carmen(path: Path) -> None:
    """A log, of which some scans are mapped."""
    from threewe.slam.carmen import read_carmen

    _map(read_carmen(path))


def read_relations(path: Path) -> None:
    """Relations between places."""
    from threewe.slam import Relations

    Relations.read(path)


def read_episodes(path: Path) -> None:
    """A frozen list of episodes."""
    from threewe.benchmark import load_episodes

    load_episodes(path)


def read_bundle(path: Path) -> None:
    """A benchmark run, as far as it is read before anything is replayed."""
    from threewe.benchmark.bundle import read_bundle

    read_bundle(path)


def read_rosbag(path: Path) -> None:
    """A recording, of which some scans are mapped."""
    from threewe.slam.rosbag import read_rosbag

    _map(read_rosbag(path))


def _map(log: Any) -> None:
    from threewe import ContractError
    from threewe.slam import Slam, SlamConfig

    slam = Slam(SlamConfig(base_from_lidar=log.base_from_lidar))
    for time_, scan, odometry in list(zip(log.times, log.scans, log.odometry, strict=True))[:REPLAYED]:
        try:
            slam.add(scan, odometry, time_ - log.times[0])
        except ContractError as error:  # what a reader lets through maps, but for what depends on the scans before
            if "ranges after scans" not in str(error) and "time must go on" not in str(error):
                raise
    slam.map()


FORMATS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "carmen": (".log", read_carmen),
    "relations": (".relations", read_relations),
    "episodes": (".json", read_episodes),
    "bundle": (".zip", read_bundle),
    "rosbag": (".mcap", read_rosbag),
}


def mutate(data: bytes, pool: list[bytes], draw: random.Random) -> bytes:
    """One change that knows words, lines and numbers, text or binary."""
    kind = draw.randrange(9)
    if not data:
        return draw.choice(pool)
    at = draw.randrange(len(data))
    if kind == 0:  # a byte
        return data[:at] + bytes([draw.randrange(256)]) + data[at + 1 :]
    if kind == 1:  # a number as bytes
        number = draw.choice(BINARY)
        return data[:at] + number + data[at + len(number) :]
    if kind == 2:  # a piece is lost
        return data[:at] + data[at + draw.randrange(1, 64) :]
    if kind == 3:  # a piece of another
        other = draw.choice(pool)
        begin = draw.randrange(len(other) + 1)
        return data[:at] + other[begin : begin + draw.randrange(1, 256)] + data[at:]
    if kind == 4:  # the end is lost
        return data[:at]
    if kind in (5, 6):  # a word becomes another
        separators = b' ,[]{}:\n"'
        begin, end = at, at
        while begin > 0 and data[begin - 1] not in separators:
            begin -= 1
        while end < len(data) and data[end] not in separators:
            end += 1
        return data[:begin] + draw.choice(EXTREMES) + data[end:]
    begin = data.rfind(b"\n", 0, at) + 1  # a line, twice or many times
    end = data.find(b"\n", at)
    line = data[begin : end + 1 if end >= 0 else len(data)]
    return data[:begin] + line * draw.choice((2, 100)) + data[begin + len(line) :]


class Reader:
    """Reads inputs in the child, and knows which lines were reached."""

    def __init__(self, read: Callable[[Path], None]) -> None:
        self._read = read
        self._lines: set[tuple[str, int]] = set()
        self._traced: dict[str, bool] = {}

    def __call__(self, path: Path) -> bool:
        """Whether the input reached a line that none had before. Raises what is no ConfigError."""
        from threewe import ConfigError

        before = len(self._lines)
        sys.settrace(self._enter)
        try:
            self._read(path)
        except ConfigError as error:
            if str(path.parent) not in str(error):
                raise AssertionError(f"no file in the message: {error}") from error
        finally:
            sys.settrace(None)
        return len(self._lines) > before

    def _enter(self, frame: FrameType, *_: object) -> Any:
        name = frame.f_code.co_filename
        if name not in self._traced:
            followed = ("/threewe/slam/", "/benchmark/episodes", "/benchmark/bundle", "/rosbags/rosbag2/")
            self._traced[name] = any(part in name for part in followed)
        return self._step if self._traced[name] else None

    def _step(self, frame: FrameType, *_: object) -> Any:
        self._lines.add((frame.f_code.co_filename, frame.f_lineno))
        return self._step


def child(name: str, seed: int, runs: int, folder: Path, pipe: Connection) -> None:
    """Reads inputs one after the other and tells each before it reads it."""
    suffix, read = FORMATS[name]
    draw = random.Random(seed)
    pool = [path.read_bytes() for path in sorted((CORPUS / name).iterdir())]
    reader = Reader(read)
    path = folder / f"input{suffix}"
    path.write_bytes(pool[0])
    reader(path)  # what is imported by the first counts for none
    for i in range(runs):
        data = pool[i] if i < len(pool) else draw.choice(pool)
        for _ in range(0 if i < len(pool) else draw.choice((1, 1, 2, 4))):
            data = mutate(data, pool, draw)[:LARGEST]
        path.write_bytes(data)
        pipe.send(i)
        signal.setitimer(signal.ITIMER_PROF, TIME_LIMIT)  # ends the process
        taken = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        if reader(path) and i >= len(pool):
            pool.append(data)
        taken = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - taken)
        if taken > FREE_MEMORY + MEMORY_PER_BYTE * len(data):
            raise MemoryError(f"{taken} bytes of memory for an input of {len(data)}")
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    pipe.send(None)


def fuzz(name: str, runs: int, seconds: float, seed: int = 1) -> tuple[int, str]:
    """How many inputs were read, and what the last one did wrong; nothing if none did."""
    context = multiprocessing.get_context("fork")
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as scratch:
        receiver, sender = context.Pipe(duplex=False)
        process = context.Process(target=child, args=(name, seed, runs, Path(scratch), sender))
        process.start()
        sender.close()
        done, failure, end = 0, "", time.monotonic() + seconds
        try:
            while time.monotonic() < end:
                if not receiver.poll(WALL_LIMIT):
                    failure = f"hangs for more than {WALL_LIMIT:g} s"
                    break
                told = receiver.recv()
                if told is None:
                    done = runs
                    break
                done = told + 1
        except EOFError:
            process.join()
            late = process.exitcode == -signal.SIGPROF
            failure = f"the reader ended with status {process.exitcode}"
            failure = f"computes for more than {TIME_LIMIT:g} s" if late else failure
        process.kill()
        process.join()
        if failure:
            kept = Path("build/fuzz/artifacts") / f"{name}-{seed}-{done}{FORMATS[name][0]}"
            kept.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(Path(scratch) / f"input{FORMATS[name][0]}", kept)
            failure += f": {kept}"
    return done, failure


def main() -> int:
    """Fuzzes one format, or reads one input."""
    parser = argparse.ArgumentParser()
    parser.add_argument("format", choices=FORMATS)
    parser.add_argument("input", nargs="?", type=Path)
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=1e9)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.input:
        Reader(FORMATS[options.format][1])(options.input)
        return 0
    done, failure = fuzz(options.format, options.runs, options.seconds, options.seed)
    print(f"{options.format}: {done} inputs{', ' + failure if failure else ''}")
    return int(bool(failure))


if __name__ == "__main__":
    sys.exit(main())
