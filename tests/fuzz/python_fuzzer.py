"""Coverage-guided fuzzing of the formats that are read in Python: `python -m tests.fuzz.python_fuzzer FORMAT`.

Inputs grow out of the seeds in corpus/<format>/: one that reaches a line which none before has reached is changed
further, and kept for the next run. Of containers every other change is one of their contents, and the container made
anew: else all end at its structure. A child process reads; its parent notices when it dies, hangs or takes too much
memory.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import math
import multiprocessing
import random
import shutil
import signal
import struct
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from types import FrameType
from typing import Any

CORPUS = Path(__file__).parent / "corpus"
TIME_LIMIT = 5.0  # [s] of computing for one input ...
WALL_LIMIT = 120.0  # [s] ... which others may keep waiting
FREE_MEMORY = 2**26  # [bytes] beside 64 for each byte of input ...
MAP_MEMORY = 2**30  # ... and where a map is drawn: two of 16.7 million cells
MEMORY_PER_BYTE = 64
LARGEST = 2**18  # [bytes] of an input
REPLAYED = 4  # scans of a log that are mapped
SCRATCH = "/dev/shm" if Path("/dev/shm").is_dir() else None

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


@dataclass(frozen=True)
class Format:
    """How files of a format are read, and what of a container's contents may be changed."""

    suffix: str
    read: Callable[[Path], None]
    free_memory: int = FREE_MEMORY
    change_content: Callable[[bytes, list[bytes], random.Random], bytes] | None = None

    def mutate(self, data: bytes, pool: list[bytes], draw: random.Random) -> bytes:
        """One change; of containers every other is one of what they contain."""
        if self.change_content and draw.random() < 0.5:
            return self.change_content(data, pool, draw)
        return mutate(data, pool, draw)


def change_member(data: bytes, _: list[bytes], draw: random.Random) -> bytes:
    """A bundle of which one file is another, and its manifest right but where that is the file."""
    from threewe.benchmark.bundle import archived, pack

    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            files = {name: archive.read(name) for name in archive.namelist()}
        name = draw.choice(sorted(files))
        files[name] = mutate(files[name], list(files.values()), draw)
        manifest = files.pop("manifest.json")
        return archived({**files, "manifest.json": manifest}) if name == "manifest.json" else pack(files)
    except Exception:  # changed beyond reading before
        return data


def change_message(data: bytes, _: list[bytes], draw: random.Random) -> bytes:
    """A recording of which one message has other values, written anew."""
    from rosbags.rosbag2 import Reader as BagReader
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    suffix, plugin = (".db3", StoragePlugin.SQLITE3) if data[:6] == b"SQLite" else (".mcap", StoragePlugin.MCAP)
    types = get_typestore(Stores.ROS2_HUMBLE)
    with tempfile.TemporaryDirectory(dir=SCRATCH) as folder:
        path, bag = Path(folder) / f"before{suffix}", Path(folder) / "bag"
        path.write_bytes(data)
        try:
            with BagReader(path) as reader:
                messages = [(c.topic, c.msgtype, stamp, raw) for c, stamp, raw in reader.messages()]
            changed = draw.randrange(len(messages))
            with Writer(bag, version=9, storage_plugin=plugin) as writer:
                found = sorted({(topic, kind) for topic, kind, *_ in messages})
                topics = {one: writer.add_connection(*one, typestore=types) for one in found}
                for i, (topic, kind, stamp, raw) in enumerate(messages):
                    content = mutate_values(raw, draw) if i == changed else raw
                    writer.write(topics[topic, kind], stamp, content)
            return (bag / f"bag{suffix}").read_bytes()
        except Exception:  # changed beyond reading before
            return data


FORMATS: dict[str, Format] = {
    "carmen": Format(".log", read_carmen, MAP_MEMORY),
    "relations": Format(".relations", read_relations),
    "episodes": Format(".json", read_episodes),
    "bundle": Format(".zip", read_bundle, change_content=change_member),
    "rosbag": Format(".mcap", read_rosbag, MAP_MEMORY, change_message),
    "rosbag_sqlite": Format(".db3", read_rosbag, MAP_MEMORY, change_message),
}


def mutate_values(data: bytes, draw: random.Random) -> bytes:
    """Some numbers become others, and stay where they are: what is 4 or 8 bytes long stands at multiples of that."""
    header = 4  # of CDR, from which places count
    for _ in range(draw.choice((1, 1, 2, 8))):
        number = draw.choice(BINARY)
        places = range(header, len(data) - len(number) + 1, len(number))
        if places:
            at = draw.choice(places)
            data = data[:at] + number + data[at + len(number) :]
    return data


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


class Memory:
    """The most that the process was given since this was made; what is asked for and never touched counts for none."""

    def __init__(self) -> None:
        Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
        self._given = self._peak()

    def taken(self) -> int:
        return self._peak() - self._given

    @staticmethod
    def _peak() -> int:
        [line] = [line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM")]
        return 1024 * int(line.split()[1])


def child(name: str, seed: int, runs: int, folder: Path, kept: Path | None, pipe: Connection) -> None:
    """Reads the seeds, the inputs in `kept`, then changed ones, and sends the number of each before it reads it."""
    form = FORMATS[name]
    draw = random.Random(seed)
    pool = [path.read_bytes() for first in (CORPUS / name, kept) if first for path in sorted(first.iterdir())]
    unchanged = len(pool)
    reader = Reader(form.read)
    path = folder / f"input{form.suffix}"
    path.write_bytes(pool[0])
    reader(path)  # what is imported by the first counts for none
    for i in range(unchanged + runs):
        data = pool[i] if i < unchanged else draw.choice(pool)
        for _ in range(0 if i < unchanged else draw.choice((1, 1, 2, 4))):
            data = form.mutate(data, pool, draw)[:LARGEST]
        path.write_bytes(data)
        pipe.send(i)
        signal.setitimer(signal.ITIMER_PROF, TIME_LIMIT)  # ends the process
        memory = Memory()
        if reader(path) and i >= unchanged:
            pool.append(data)
            if kept:
                (kept / hashlib.sha1(data).hexdigest()).write_bytes(data)
        if (taken := memory.taken()) > form.free_memory + MEMORY_PER_BYTE * len(data):
            raise MemoryError(f"{taken} bytes of memory for an input of {len(data)}")
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    pipe.send(None)


def fuzz(name: str, runs: int, seconds: float, seed: int = 1, kept: Path | None = None) -> tuple[int, str]:
    """How many inputs were read, `runs` of them changed, and what the last one did wrong; nothing if none did."""
    context = multiprocessing.get_context("fork")
    with tempfile.TemporaryDirectory(dir=SCRATCH) as scratch:
        receiver, sender = context.Pipe(duplex=False)
        process = context.Process(target=child, args=(name, seed, runs, Path(scratch), kept, sender))
        process.start()
        sender.close()
        done, failure, end = 0, "", time.monotonic() + seconds
        try:
            while time.monotonic() < end:
                if not receiver.poll(WALL_LIMIT):
                    failure = f"hangs for more than {WALL_LIMIT:g} s"
                    break
                number = receiver.recv()
                if number is None:
                    break
                done = number + 1
        except EOFError:
            process.join()
            late = process.exitcode == -signal.SIGPROF
            failure = f"the reader ended with status {process.exitcode}"
            failure = f"computes for more than {TIME_LIMIT:g} s" if late else failure
        process.kill()
        process.join()
        if failure:
            kept = Path("build/fuzz/artifacts") / f"{name}-{seed}-{done}{FORMATS[name].suffix}"
            kept.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(Path(scratch) / f"input{FORMATS[name].suffix}", kept)
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
        Reader(FORMATS[options.format].read)(options.input)
        return 0
    done, failure = fuzz(options.format, options.runs, options.seconds, options.seed)
    print(f"{options.format}: {done} inputs{', ' + failure if failure else ''}")
    return int(bool(failure))


if __name__ == "__main__":
    sys.exit(main())
