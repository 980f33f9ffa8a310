"""Parquet files that others wrote: checked before they are read, and read in pieces that stay small."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from threewe.errors import ConfigError

if TYPE_CHECKING:
    import pyarrow as pa

LARGEST_TABLE = 2**29
"""[bytes] of rows that are held at once."""
LARGEST_PIECE = 64 * 2**20
"""[bytes] that are decoded at once, as far as a file can say."""
MOST_ROWS = 20_000_000
"""Of one file: LeRobot's hold at most some 100 MiB."""
SNAPPY_RATIO = 32
"""Snappy can not compress by more than about 21; a file that says so lies."""
CODECS = ("SNAPPY", "UNCOMPRESSED")


class ParquetTable:
    """A Parquet file. Raises ConfigError where it is damaged, compressed in another way than LeRobot's, or a bomb."""

    def __init__(self, path: Path) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        self.path = path
        self._numbers: dict[str, NDArray[np.int64]] = {}
        try:
            limits = {"thrift_string_size_limit": 2**24, "thrift_container_size_limit": 2**20}
            self.file: Any = pq.ParquetFile(path, pre_buffer=False, **limits)
            self.schema: pa.Schema = self.file.schema_arrow
            self.groups = [self.file.metadata.row_group(i) for i in range(self.file.num_row_groups)]
            self.rows = sum(group.num_rows for group in self.groups)
            self._check()
        except ConfigError:
            raise
        except (pa.ArrowException, OSError, ValueError, OverflowError) as error:
            raise ConfigError(f"{path}: no Parquet file that can be read: {first_line(error)}") from None

    def read(self, columns: Sequence[str], first: int = 0, end: int | None = None) -> pa.Table:
        """Rows `first` to `end` of some columns. Raises ConfigError."""
        import pyarrow as pa

        batches = list(self.pieces(columns, first, end))
        if sum(batch.nbytes for batch in batches) > LARGEST_TABLE:
            raise ConfigError(f"{self.path}: rows {first} to {end} need more than {LARGEST_TABLE} bytes")
        empty = pa.schema([self.schema.field(name) for name in columns])
        return pa.Table.from_batches(batches) if batches else empty.empty_table()

    def pieces(self, columns: Sequence[str], first: int = 0, end: int | None = None) -> Iterator[pa.RecordBatch]:
        """Those rows, some at a time. Raises ConfigError."""
        end = self.rows if end is None else end
        taken = position = 0
        for i, group in enumerate(self.groups):
            begin, position = position, position + group.num_rows
            if position <= first or begin >= end:
                continue
            for batch in self._batches(i, columns):
                low, high = max(first - begin, 0), min(end - begin, batch.num_rows)
                begin += batch.num_rows
                if low >= high:
                    continue
                piece = batch.slice(low, high - low)
                taken += piece.nbytes
                if taken > LARGEST_TABLE:
                    raise ConfigError(f"{self.path}: rows {first} to {end} need more than {LARGEST_TABLE} bytes")
                yield piece
                if begin >= end:
                    break

    def require(self, names: Sequence[str]) -> None:
        """Raises ConfigError for columns that are missing."""
        if missing := [name for name in names if name not in self.schema.names]:
            raise ConfigError(f"{self.path}: columns {', '.join(missing)!s:.200} missing")

    def numbers(self, name: str) -> NDArray[np.int64]:
        """A column of whole numbers, which is read once. Raises ConfigError."""
        import pyarrow as pa

        if name in self._numbers:
            return self._numbers[name]
        self.require([name])
        if self.schema.field(name).type != pa.int64():
            raise ConfigError(f"{self.path}: column {name} is {self.schema.field(name).type}; it must be int64")
        column = self.read([name]).column(name)
        if column.null_count:
            raise ConfigError(f"{self.path}: column {name} has empty rows")
        self._numbers[name] = column.to_numpy().astype(np.int64, copy=False)
        return self._numbers[name]

    def _batches(self, group: int, columns: Sequence[str]) -> Iterator[pa.RecordBatch]:
        import pyarrow as pa

        size = self._rows_at_once(group, columns)
        options = {"row_groups": [group], "columns": list(columns), "use_threads": False}
        try:
            for batch in self.file.iter_batches(size, **options):
                batch.validate(full=True)  # offsets, and texts that are UTF-8
                yield batch
        except (pa.ArrowException, OSError, ValueError, OverflowError) as error:
            raise ConfigError(f"{self.path}: row group {group} is damaged: {first_line(error)}") from None

    def _rows_at_once(self, group: int, columns: Sequence[str]) -> int:
        """So many that a piece stays small, even where each row repeats the largest value that the file can hold."""
        largest = 8
        for i in range(self.groups[group].num_columns):
            column = self.groups[group].column(i)
            name = column.path_in_schema
            if not any(name == wanted or name.startswith(wanted + ".") for wanted in columns):
                continue
            if column.physical_type == "BYTE_ARRAY" or ".list." in name:
                largest = max(largest, column.total_uncompressed_size)
        return max(1, min(65_536, LARGEST_PIECE // largest))

    def _check(self) -> None:
        size = self.path.stat().st_size
        if not 0 <= self.rows <= MOST_ROWS or any(group.num_rows < 0 for group in self.groups):
            raise ConfigError(f"{self.path}: {self.rows} rows; at most {MOST_ROWS} are read")
        if self.rows != self.file.metadata.num_rows:
            raise ConfigError(f"{self.path}: {self.file.metadata.num_rows} rows in all, {self.rows} in its row groups")
        for group in self.groups:
            for i in range(group.num_columns):
                column = group.column(i)
                where = f"{self.path}: column {column.path_in_schema!r:.80}"
                if column.compression not in CODECS:
                    raise ConfigError(
                        f"{where} is {column.compression}; read are {' and '.join(CODECS)}, as LeRobot writes"
                    )
                if not 0 <= column.total_compressed_size <= size:
                    raise ConfigError(f"{where} has {column.total_compressed_size} bytes, the file {size}")
                if not 0 <= column.total_uncompressed_size <= SNAPPY_RATIO * size + 2**16:
                    raise ConfigError(f"{where} would be {column.total_uncompressed_size} bytes of a file of {size}")


def first_line(error: BaseException) -> str:
    """What an error says, in a line."""
    return str(error).strip().splitlines()[0][:300] if str(error).strip() else type(error).__name__
