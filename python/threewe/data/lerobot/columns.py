"""Columns of a table as numpy arrays of their features' types and shapes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from threewe.data.lerobot.features import Feature
from threewe.data.lerobot.tables import frame_field
from threewe.errors import ConfigError

if TYPE_CHECKING:
    import pyarrow as pa


def require_type(schema: pa.Schema, name: str, feature: Feature, path: Path) -> None:
    """Raises ConfigError where a column has another type than its feature says."""
    import pyarrow as pa

    found, wanted = schema.field(name).type, frame_field(name, feature).type
    if isinstance(found, pa.BaseExtensionType):
        found = found.storage_type
    if not alike(found, wanted):
        raise ConfigError(f"{path}: column {name} is {found!s:.120}; meta/info.json says {wanted}")


def alike(found: pa.DataType, wanted: pa.DataType) -> bool:
    """Whether values are the same: writers differ in lists of fixed and of any length, and in large ones."""
    import pyarrow as pa

    lists = (pa.types.is_list, pa.types.is_large_list, pa.types.is_fixed_size_list)
    if any(is_list(found) for is_list in lists) and any(is_list(wanted) for is_list in lists):
        return alike(found.value_type, wanted.value_type)
    if pa.types.is_struct(wanted):
        return bool(pa.types.is_struct(found) and {field.name for field in found} == {"bytes", "path"})
    if pa.types.is_string(wanted):
        return bool(pa.types.is_string(found) or pa.types.is_large_string(found))
    return bool(found == wanted)


def to_numpy(table: pa.Table, name: str, feature: Feature, where: str, first: int = 0) -> NDArray[Any]:
    """A column's rows: `(rows,)` for shape (1,), else `(rows, *shape)`. Raises ConfigError with the row."""
    import pyarrow as pa

    column = table.column(name).combine_chunks()
    if isinstance(column, pa.ChunkedArray):
        column = pa.concat_arrays(column.chunks) if column.num_chunks else pa.array([], column.type)
    rows = len(column)
    if isinstance(column.type, pa.BaseExtensionType):
        column = column.storage
    if column.null_count:
        row = int(np.argmax(column.is_null().to_numpy(zero_copy_only=False)))
        raise ConfigError(f"{where}: row {first + row}: {name} is empty")
    if feature.dtype == "string":
        return np.array(column.to_pylist(), dtype=object)
    for length in [] if feature.shape == (1,) else feature.shape:
        column = flattened(column, length, name, where, first)
    if column.null_count:
        raise ConfigError(f"{where}: {name} has empty entries")
    values: NDArray[Any] = column.to_numpy(zero_copy_only=False).astype(feature.dtype, copy=False)
    shape = (rows,) if feature.shape == (1,) else (rows, *feature.shape)
    values = values.reshape(shape)
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        row = int(np.argwhere(~np.isfinite(values))[0][0])
        raise ConfigError(f"{where}: row {first + row}: {name} is not finite")
    return values


def flattened(column: pa.Array, length: int, name: str, where: str, first: int) -> pa.Array:
    """The entries of lists that all have this length. Raises ConfigError with the row."""
    import pyarrow as pa
    import pyarrow.compute as pc

    if pa.types.is_fixed_size_list(column.type):
        wrong = column.type.list_size != length
        row = 0
    else:
        lengths = pc.list_value_length(column).to_numpy(zero_copy_only=False)
        wrong, row = bool((lengths != length).any()), int(np.argmax(lengths != length))
    if wrong:
        raise ConfigError(f"{where}: row {first + row}: {name} has another length than the {length} of meta/info.json")
    return column.flatten()
