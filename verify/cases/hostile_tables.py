"""Tables of a dataset with other contents: wrong types, huge counts, NaN, bombs."""

from __future__ import annotations

import io
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from verify.cases.hostile_files import DATA, EPISODES, TASKS

Attack = Callable[[Path, random.Random], None]
CAMERA = "videos/observation.images.front"


def replace(file: str, column: str, values: Callable[[pa.ChunkedArray], Any] | None, **options: Any) -> Attack:
    """A column with other values or of another type; without, if there are none."""

    def attack(root: Path, _: random.Random) -> None:
        table = pq.read_table(root / file)
        place = table.schema.names.index(column)
        table = table.remove_column(place)
        if values is not None:
            made = values(pq.read_table(root / file, columns=[column]).column(0))
            table = table.add_column(
                place, column, made if isinstance(made, pa.Array | pa.ChunkedArray) else pa.array(made)
            )
        pq.write_table(table, root / file, **options)

    return attack


def cell(file: str, column: str, value: Any) -> Attack:
    """One other value, in a row that is drawn."""

    def attack(root: Path, rng: random.Random) -> None:
        table = pq.read_table(root / file)
        field = table.schema.field(column)
        values = table.column(column).to_pylist()
        values[rng.randrange(len(values))] = value
        kind = field.type if fits(value, field.type) else None
        table = table.set_column(table.schema.names.index(column), column, pa.array(values, kind, from_pandas=False))
        pq.write_table(table, root / file)

    return attack


def fits(value: Any, kind: pa.DataType) -> bool:
    """Whether a value has this type."""
    try:
        pa.array([value], kind, from_pandas=False)
    except (pa.ArrowException, TypeError, OverflowError):
        return False
    return True


def bomb(file: str, columns: dict[str, Any], **options: Any) -> Attack:
    """A small file of a large table."""

    def attack(root: Path, _: random.Random) -> None:
        made = {name: values() if callable(values) else values for name, values in columns.items()}
        pq.write_table(pa.table(made), root / file, **options)

    return attack


def rename(file: str, column: str, name: str) -> Attack:
    """A column of another name."""

    def attack(root: Path, _: random.Random) -> None:
        table = pq.read_table(root / file)
        names = [name if known == column else known for known in table.schema.names]
        pq.write_table(table.rename_columns(names), root / file)

    return attack


def no_text(file: str, text: bytes) -> Attack:
    """Bytes that are no UTF-8 in place of a text, wherever it is in a file."""

    def attack(root: Path, _: random.Random) -> None:
        content = (root / file).read_bytes()
        (root / file).write_bytes(content.replace(text, b"\xff" * len(text)))

    return attack


def picture(content: Callable[[bytes], bytes | None]) -> Attack:
    """Another file in place of an image in the table."""

    def attack(root: Path, rng: random.Random) -> None:
        name = "observation.images.still"
        table = pq.read_table(root / DATA)
        values = table.column(name).to_pylist()
        i = rng.randrange(len(values))
        values[i] = {"bytes": content(values[i]["bytes"]), "path": "../../../../tmp/evil.png"}
        kind = table.schema.field(name).type
        pq.write_table(table.set_column(table.schema.names.index(name), name, pa.array(values, kind)), root / DATA)

    return attack


def huge_png(content: bytes) -> bytes:
    """A head that announces 60,000 x 60,000 pixels."""
    changed = io.BytesIO(content)
    changed.seek(16)
    changed.write((60_000).to_bytes(4, "big") * 2)
    return changed.getvalue()


def repeated(text: str, count: int) -> pa.DictionaryArray:
    """A text that is in the file once."""
    return pa.DictionaryArray.from_arrays(pa.array(np.zeros(count, np.int32)), pa.array([text]))


PLAIN = {"store_schema": False, "dictionary_pagesize_limit": 2**30}
"""So that a reader takes it for a column of texts."""


def ones(count: int) -> Callable[[], Any]:
    return lambda: np.ones(count, np.int64)


NAN, INFINITE = float("nan"), float("inf")
COUNTS = (
    "episode_index",
    "length",
    "dataset_from_index",
    "dataset_to_index",
    "data/chunk_index",
    f"{CAMERA}/file_index",
)
TABLES: dict[str, Attack] = {
    **{f"{column} {value}": cell(EPISODES, column, value) for column in COUNTS for value in (-1, 2**62, None)},
    **{f"{column} of texts": replace(EPISODES, column, lambda old: ["x"] * len(old)) for column in COUNTS},
    **{f"{column} of fractions": replace(EPISODES, column, lambda old: [0.5] * len(old)) for column in COUNTS},
    **{f"{column} missing": replace(EPISODES, column, None) for column in (*COUNTS, "tasks")},
    **{
        f"{edge} {value}": cell(EPISODES, f"{CAMERA}/{edge}_timestamp", value)
        for edge in ("from", "to")
        for value in (NAN, INFINITE, -1.0, 1e300, None)
    },
    "tasks of numbers": replace(EPISODES, "tasks", lambda old: [[1]] * len(old)),
    "tasks that are null": cell(EPISODES, "tasks", None),
    "statistics with NaN": cell(EPISODES, "stats/action/mean", [NAN, 0.0]),
    "statistics without a name": rename(EPISODES, "stats/action/mean", "stats/mean"),
    "statistics that are null": cell(EPISODES, "stats/action/mean", None),
    "statistics of texts": replace(EPISODES, "stats/action/std", lambda old: [["x"]] * len(old)),
    "action NaN": cell(DATA, "action", [NAN, 0.0]),
    "action infinite": cell(DATA, "action", [0.0, -INFINITE]),
    "action null": cell(DATA, "action", None),
    "action of another length": replace(
        DATA, "action", lambda old: pa.array([[1.0]] * len(old), pa.list_(pa.float32()))
    ),
    "action of many lengths": replace(
        DATA, "action", lambda old: pa.array([[1.0] * (i % 4) for i in range(len(old))], pa.list_(pa.float32()))
    ),
    "action of texts": replace(DATA, "action", lambda old: [["a", "b"]] * len(old)),
    "action of doubles": replace(DATA, "action", lambda old: pa.array([[0.0, 1.0]] * len(old), pa.list_(pa.float64()))),
    "action missing": replace(DATA, "action", None),
    "success of numbers": replace(DATA, "next.success", lambda old: [1] * len(old)),
    "timestamp NaN": cell(DATA, "timestamp", NAN),
    "timestamp missing": replace(DATA, "timestamp", None),
    "episode_index of no episode": replace(DATA, "episode_index", lambda old: [77] * len(old)),
    "episode_index of texts": replace(DATA, "episode_index", lambda old: ["0"] * len(old)),
    "episode_index null": cell(DATA, "episode_index", None),
    "episodes mixed up": replace(DATA, "episode_index", lambda old: [i % 2 for i in range(len(old))]),
    "task_index out of range": cell(DATA, "task_index", 10**12),
    "task_index negative": cell(DATA, "task_index", -1),
    "frames compressed by zstd": replace(DATA, "timestamp", lambda old: old.combine_chunks(), compression="zstd"),
    "tasks: numbers that do not count": replace(TASKS, "task_index", lambda old: [5] * len(old)),
    "tasks: no text": replace(TASKS, "task", lambda old: pa.array([None] * len(old), pa.string())),
    "names of columns that are no UTF-8": no_text(DATA, b"next.success"),
    "tasks that are no UTF-8": no_text(TASKS, b"stop"),
    "tasks: bytes": replace(TASKS, "task", lambda old: [b"\xff\xfe"] * len(old)),
    "bomb: 30 million rows of frames": bomb(DATA, {"episode_index": ones(30_000_000)}),
    "bomb: zeros by zstd": bomb(TASKS, {"task_index": ones(10_000_000)}, compression="zstd", use_dictionary=False),
    "bomb: zeros by snappy": bomb(TASKS, {"task_index": ones(10_000_000)}, use_dictionary=False),
    "bomb: a long text ten thousand times": bomb(
        TASKS, {"task_index": lambda: np.arange(10_000), "task": lambda: repeated("x" * 900_000, 10_000)}, **PLAIN
    ),
    "bomb: a long text in each frame": replace(DATA, "note", lambda old: repeated("x" * 90_000_000, len(old)), **PLAIN),
    "bomb: long tasks of an episode": bomb(
        EPISODES,
        {
            **dict.fromkeys(("episode_index", "length", "dataset_from_index", "dataset_to_index"), ones(1)),
            "tasks": lambda: [["y" * 900_000] * 20],
        },
    ),
    "image: no bytes": picture(lambda _: None),
    "image: empty": picture(lambda _: b""),
    "image: text": picture(lambda _: b"hello"),
    "image: cut off": picture(lambda content: content[: len(content) // 3]),
    "image: 60,000 pixels wide": picture(huge_png),
    "image: a playlist": picture(lambda _: b"#EXTM3U\n/etc/passwd\n"),
    "image: GIF": picture(lambda _: b"GIF89a" + bytes(20)),
    "image: SVG": picture(lambda _: b"<svg><image href='file:///etc/passwd'/></svg>"),
    "images of texts": replace(DATA, "observation.images.still", lambda old: ["a.png"] * len(old)),
}
