"""LeRobot datasets that were spoiled on purpose: each must be refused with one ConfigError, and nothing else happen."""

from __future__ import annotations

import json
import os
import random
import resource
import shutil
import struct
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from threewe.data.lerobot import ArrayFrames, Dataset, DatasetWriter
from threewe.errors import ConfigError

from verify.cases.hostile_files import FILES
from verify.cases.hostile_tables import TABLES

CASES = 200
CAMERA, STILL = "observation.images.front", "observation.images.still"
MEMORY = 2**20
"""[KiB] that reading may take in all, libraries among them."""
Attack = Callable[[Path, random.Random], None]

PATHS: list[Any] = [
    "../../../etc/passwd",
    "/etc/passwd",
    "data/../../{chunk_index:03d}",
    "data/{chunk_index.__class__.__mro__}",
    "data/{chunk_index.__class__.__init__.__globals__}",
    "data/{chunk_index!r}",
    "data/{chunk_index:>99999999999d}",
    "data/{chunk_index:{file_index}}",
    "data/{0}",
    "data/{}",
    "data/{somewhere}",
    "data/{chunk_index",
    "data/\0.parquet",
    "data\\..\\..\\file",
    "",
    "d" * 600,
    7,
    None,
    ["data"],
    {"a": 1},
]
NAMES = ["../../escape", "/etc/passwd", "a/b", "..", "", "x\0y", "n" * 300, "a\\b", "line\nbreak", "{chunk_index}"]
NO_COUNTS: list[Any] = [-1, 10**30, "3", 3.5, True, None, [], {}]
INFO: list[tuple[str, list[Any]]] = [
    ("codebase_version", ["v9.9", "v3.0; rm -rf /", 3, None, [], {"v": 3}]),
    ("fps", [0, -5, *NO_COUNTS]),
    ("total_episodes", [0, 3, 10**6, *NO_COUNTS]),
    ("total_frames", [0, 25, 10**12, *NO_COUNTS]),
    ("total_tasks", [0, 7, *NO_COUNTS]),
    ("chunks_size", [0, *NO_COUNTS[:-3], [], {}]),
    ("data_files_size_in_mb", [0, -1, "a", [], True]),
    ("robot_type", [7, [], {}]),
    ("features", [None, [], "x", {}, 3, {"a": None}, {str(i): {} for i in range(2000)}]),
]
FEATURE: list[tuple[str, list[Any]]] = [
    ("dtype", ["object", "pickle", "O", ["float32"], None, 7, "video", "float128"]),
    ("shape", [None, [], [-1], [0], ["3"], [[3]], [10**9], [2.5], 10**12, [True], [2, 2, 2, 2, 2, 2], [4]]),
]
CAMERA_SHAPE: list[Any] = [[99_999, 99_999, 3], [48, 64, 4], [48], [0, 64, 3], [49, 64, 3], [48, 64, 1]]


def attacks() -> dict[str, Attack]:
    """All that are written by hand, by name."""
    found: dict[str, Attack] = {}
    for name in ("data_path", "video_path"):
        for i, path in enumerate(PATHS if name == "data_path" else [path for path in PATHS if path]):
            found[f"{name} {i} {path!r:.40}"] = set_info(name, path)
    for i, wrong in enumerate(NAMES):
        found[f"feature name {i} {wrong!r:.40}"] = rename_feature(wrong)
    for name, values in INFO:
        for i, value in enumerate(values):
            found[f"{name} {i} {value!r:.40}"] = set_info(name, value)
    for name, values in FEATURE:
        for i, value in enumerate(values):
            found[f"feature {name} {i} {value!r:.40}"] = set_feature("action", name, value)
    for i, value in enumerate(CAMERA_SHAPE):
        found[f"camera shape {i} {value!r:.40}"] = set_feature(CAMERA, "shape", value)
    return {**found, **FILES, **TABLES}


def cases(seed: int, count: int = CASES) -> Iterator[tuple[str, Attack]]:
    """`count` of them: a share of those written by hand, and drawn ones."""
    rng = random.Random(seed)
    written = list(attacks().items())
    rng.shuffle(written)
    yield from written[: count * 3 // 4]
    for i in range(count - min(len(written), count * 3 // 4)):
        name, attack = rng.choice(DRAWN)
        yield f"drawn {i}: {name}", attack


def meet(name: str, attack: Attack, seed: int) -> dict[str, Any]:
    """Spoils a dataset and reads all of it; what came of it. `refused` is the one line that a user gets."""
    with tempfile.TemporaryDirectory() as place:
        outside = Path(place) / "outside"
        outside.mkdir()
        (outside / "secret.txt").write_text("not yours\n")
        root = sound_dataset(Path(place) / "inside" / "dataset")
        attack(root, random.Random(f"{seed} {name}"))
        before = listing(Path(place))
        try:
            read_everything(root)
        except ConfigError as error:
            said: str | None = str(error)
        else:
            said = None
        untouched = listing(Path(place)) == before
        leaked = said is not None and "not yours" in said
        shutil.rmtree(root.parent, ignore_errors=True)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {"name": name, "refused": said, "untouched": untouched, "leaked": leaked, "memory": memory}


def read_everything(root: Path) -> None:
    """Whatever a program could ask of a dataset. Raises ConfigError."""
    dataset = Dataset.open(root)
    dataset.stats()
    for episode in dataset.episodes:
        columns = episode.columns()
        episode.frame_tasks(columns)
        episode.stats()
        for camera in episode.cameras():
            source = episode.video(camera)
            for i in range(len(source)):
                source.image(i)


def sound_dataset(root: Path) -> Path:
    """Two small episodes with a video and images in the table."""
    rng = np.random.default_rng(0)
    image = ["height", "width", "channels"]
    features = {
        "action": {"dtype": "float32", "shape": [2], "names": ["v", "w"]},
        "next.success": {"dtype": "bool", "shape": [1], "names": None},
        "note": {"dtype": "string", "shape": [1], "names": None},
        CAMERA: {"dtype": "video", "shape": [48, 64, 3], "names": image},
        STILL: {"dtype": "image", "shape": [16, 16, 3], "names": image},
    }
    with DatasetWriter(root, fps=10, features=features, robot_type="3we") as writer:
        for task in ("go", "stop"):
            columns = {"action": rng.normal(size=(12, 2)), "next.success": np.arange(12) == 11, "note": ["n"] * 12}
            front = np.repeat(np.repeat(rng.integers(0, 256, (12, 6, 8, 3), np.uint8), 8, 1), 8, 2)
            still = rng.integers(0, 256, (12, 16, 16, 3), np.uint8)
            writer.add_episode(columns, task, {CAMERA: ArrayFrames(front), STILL: ArrayFrames(still)})
    return root


def set_info(name: str, value: Any) -> Attack:
    """Another value in `meta/info.json`."""

    def attack(root: Path, _: random.Random) -> None:
        edit_info(root, lambda info: info.update({name: value}))

    return attack


def set_feature(feature: str, name: str, value: Any) -> Attack:
    """Another value of a feature."""

    def attack(root: Path, _: random.Random) -> None:
        edit_info(root, lambda info: info["features"][feature].update({name: value}))

    return attack


def rename_feature(name: str) -> Attack:
    """A camera of another name, which is that of a folder."""

    def attack(root: Path, _: random.Random) -> None:
        edit_info(root, lambda info: info["features"].update({name: info["features"].pop(CAMERA)}))

    return attack


def edit_info(root: Path, edit: Callable[[dict[str, Any]], None]) -> None:
    path = root / "meta/info.json"
    info = json.loads(path.read_text())
    edit(info)
    path.write_text(json.dumps(info))


def cut_off(root: Path, rng: random.Random) -> None:
    """A file ends early."""
    path = rng.choice(content(root))
    size = path.stat().st_size
    os.truncate(path, rng.randrange(size - min(size // 8, 200)))


def overwritten_head(root: Path, rng: random.Random) -> None:
    """The first bytes are others."""
    overwrite(rng.choice(content(root)), 0, rng.randbytes(rng.randrange(8, 64)))


def overwritten_tail(root: Path, rng: random.Random) -> None:
    """The last bytes of a table are others: its index."""
    path = rng.choice([path for path in content(root) if path.suffix == ".parquet"])
    overwrite(path, path.stat().st_size - 8, rng.randbytes(8))


def overwritten_index(root: Path, rng: random.Random) -> None:
    """The size of one of a video's boxes is another."""
    path = next(iter(root.rglob("*.mp4")))
    names = [name for name in (b"moov", b"trak", b"mdia", b"minf", b"stbl", b"stsz") if name in path.read_bytes()]
    place = path.read_bytes().index(rng.choice(names)) - 4
    overwrite(path, place, struct.pack(">I", rng.choice([2, 7, 2**31, 2**32 - 1])))


def junk_in_info(root: Path, rng: random.Random) -> None:
    """A field of another type."""
    name = rng.choice(["fps", "total_episodes", "total_frames", "total_tasks", "features", "codebase_version"])
    junk = rng.choice(["x" * 100, -rng.random(), [rng.random()], {"a": rng.random()}, None, -rng.randrange(1, 10**9)])
    edit_info(root, lambda info: info.update({name: junk}))


def content(root: Path) -> list[Path]:
    """All files that are read."""
    return sorted(path for path in root.rglob("*") if path.is_file())


def overwrite(path: Path, place: int, content: bytes) -> None:
    with path.open("r+b") as file:
        file.seek(place)
        file.write(content)


def listing(place: Path) -> list[tuple[str, int, int]]:
    """Everything below a folder: names, sizes, times of change."""
    found = []
    for path in sorted(place.rglob("*")):
        status = path.lstat()
        found.append((str(path), status.st_size, status.st_mtime_ns))
    return found


DRAWN: list[tuple[str, Attack]] = [
    ("cut off", cut_off),
    ("first bytes", overwritten_head),
    ("last bytes", overwritten_tail),
    ("box size", overwritten_index),
    ("junk in info", junk_in_info),
]


if __name__ == "__main__":
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    wrong = []
    for name, attack in cases(seed):
        outcome = meet(name, attack, seed)
        if not outcome["refused"] or not outcome["untouched"] or outcome["leaked"]:
            wrong.append(outcome)
        print(outcome["memory"] // 1024, "MiB", name, "->", outcome["refused"])
    print(f"seed {seed}: {len(wrong)} wrong", *wrong, sep="\n")
