"""Tables of a LeRobot dataset as Parquet: columns of frames, tasks, episodes; schemas as LeRobot 0.6.1 writes them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from threewe.data.lerobot.features import Feature

if TYPE_CHECKING:
    import pyarrow as pa

EXTENSION = "datasets.features.features.Array{}DExtensionType"


def frame_schema(features: Mapping[str, Feature]) -> pa.Schema:
    """The schema of the table of frames, with what the `datasets` library wants to know of it."""
    import pyarrow as pa

    described = {name: described_type(feature) for name, feature in features.items()}
    metadata = {b"huggingface": json.dumps({"info": {"features": described}}).encode()}
    return pa.schema([frame_field(name, feature) for name, feature in features.items()], metadata)


def frame_field(name: str, feature: Feature) -> pa.Field:
    """A column's type."""
    import pyarrow as pa

    if feature.dtype == "image":
        return pa.field(name, pa.struct([("bytes", pa.binary()), ("path", pa.string())]))
    number = pa.string() if feature.dtype == "string" else pa.from_numpy_dtype(np.dtype(feature.dtype))
    if feature.shape == (1,):
        return pa.field(name, number)
    if len(feature.shape) == 1:
        return pa.field(name, pa.list_(pa.field("element", number), feature.shape[0]))
    nested = number
    for _ in feature.shape:
        nested = pa.list_(pa.field("element", nested))
    extension = {
        "ARROW:extension:metadata": json.dumps([list(feature.shape), feature.dtype]),
        "ARROW:extension:name": EXTENSION.format(len(feature.shape)),
    }
    return pa.field(name, nested, metadata=extension)


def described_type(feature: Feature) -> dict[str, Any]:
    """A column's type in the words of the `datasets` library."""
    if feature.dtype == "image":
        return {"_type": "Image"}
    value = {"dtype": feature.dtype, "_type": "Value"}
    if feature.shape == (1,):
        return value
    if len(feature.shape) == 1:
        return {"feature": value, "length": feature.shape[0], "_type": "List"}
    return {"shape": list(feature.shape), "dtype": feature.dtype, "_type": f"Array{len(feature.shape)}D"}


def frame_table(columns: Mapping[str, Any], features: Mapping[str, Feature]) -> pa.Table:
    """A table of an episode's frames; images are given as lists of PNG or TIFF files."""
    import pyarrow as pa

    schema = frame_schema(features)
    arrays = [frame_array(columns[name], features[name], schema.field(name).type) for name in features]
    return pa.Table.from_arrays(arrays, schema=schema)


def frame_array(values: Any, feature: Feature, kind: pa.DataType) -> pa.Array:
    """One column."""
    import pyarrow as pa

    if feature.dtype == "image":
        suffix = "tiff" if feature.is_depth else "png"
        rows = [{"bytes": content, "path": f"frame-{i:06d}.{suffix}"} for i, content in enumerate(values)]
        return pa.array(rows, kind)
    if feature.dtype == "string":
        return pa.array([str(value) for value in values], kind)
    array = pa.array(np.ascontiguousarray(values).reshape(-1))
    if len(feature.shape) == 1:
        return array if feature.shape == (1,) else pa.FixedSizeListArray.from_arrays(array, type=kind)
    types = [kind]
    while pa.types.is_list(types[-1].value_type):
        types.append(types[-1].value_type)
    for length, type_ in zip(reversed(feature.shape), reversed(types), strict=True):
        offsets = pa.array(np.arange(0, len(array) + 1, length, dtype=np.int32))
        array = pa.ListArray.from_arrays(offsets, array, type=type_)
    return array


def write_tasks(path: Path, tasks: Sequence[str]) -> None:
    """`meta/tasks.parquet`: the numbers of tasks, indexed by their texts as pandas does."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    def column(name: str, kind: str, numpy: str) -> dict[str, Any]:
        return {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy, "metadata": None}

    index = {"name": None, "field_name": None, "pandas_type": "unicode", "numpy_type": "object"}
    pandas = {
        "index_columns": ["task"],
        "column_indexes": [{**index, "metadata": {"encoding": "UTF-8"}}],
        "columns": [column("task_index", "int64", "int64"), column("task", "unicode", "object")],
        "attributes": {},
        "creator": {"library": "pyarrow", "version": pa.__version__},
        "pandas_version": "2.3.3",
    }
    kinds = [("task_index", pa.int64()), ("task", pa.string())]
    schema = pa.schema(kinds, metadata={b"pandas": json.dumps(pandas).encode()})
    table = pa.table([pa.array(range(len(tasks)), pa.int64()), pa.array(list(tasks), pa.string())], schema=schema)
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(table, path)


def episode_table(rows: Sequence[Mapping[str, Any]]) -> pa.Table:
    """Rows of `meta/episodes`; arrays are lists of doubles, counts of whole numbers."""
    import pyarrow as pa

    def kind(value: Any) -> pa.DataType:
        if isinstance(value, bool | int):
            return pa.int64()
        if isinstance(value, float):
            return pa.float64()
        if isinstance(value, str):
            return pa.string()
        return pa.list_(pa.field("element", kind(value[0])))

    plain = [{name: plain_value(value) for name, value in row.items()} for row in rows]
    schema = pa.schema([pa.field(name, kind(value)) for name, value in plain[0].items()])
    return pa.Table.from_pylist(plain, schema=schema)


def plain_value(value: Any) -> Any:
    """A statistic as JSON and Parquet keep it."""
    if isinstance(value, np.ndarray):
        return value.astype(np.int64 if value.dtype.kind in "iu" else np.float64).tolist()
    return value


def plain_stats(stats: Mapping[str, Mapping[str, NDArray[Any]]]) -> dict[str, dict[str, Any]]:
    """All statistics as JSON keeps them."""
    return {name: {key: plain_value(value) for key, value in each.items()} for name, each in stats.items()}
