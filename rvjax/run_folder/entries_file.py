"""The entries of a large run folder in a Parquet file next to the manifest, which names it with its SHA-256.

A row is a data file: `part`, `number`, `sha256`, `bytes`, `first`, `count`, in ascending order of part and number. The file's
name has 16 digits of its SHA-256, so a new file never replaces the one that the manifest names.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from typing import Annotated, Any, cast

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from pydantic import BaseModel, ConfigDict, Field

from rvjax.run_folder import atomic_files
from rvjax.run_folder.entries import CODED, EntryRows, codes_of
from rvjax.run_folder.entry import LARGEST, Digest

_NAME = re.compile(r"entries-[0-9a-f]{16}\.parquet")

_BLOCK = 16_384
"""Rows of a row group: what is decoded at a time."""

_WHOLE_NUMBERS = ("number", "bytes", "first", "count")
_SCHEMA = pa.schema(
    [
        ("part", pa.dictionary(pa.int8(), pa.string())),
        ("number", pa.int64()),
        ("sha256", pa.binary(32)),
        *((name, pa.int64()) for name in _WHOLE_NUMBERS[1:]),
    ]
)


class EntriesFile(BaseModel):
    """The reference of a manifest to its entries file. count: the number of entries."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    sha256: Digest
    count: Annotated[int, Field(ge=1, le=LARGEST)]

    @property
    def name(self) -> str:
        """The name of the file in the run folder."""
        return f"entries-{self.sha256[:16]}.parquet"


def is_entries_file(name: str) -> bool:
    """Whether this is the name of an entries file."""
    return _NAME.fullmatch(name) is not None


def encode(rows: EntryRows) -> tuple[EntriesFile, bytes]:
    """The file as bytes, and the reference to it. The same entries give the same bytes."""
    sink, encodings = io.BytesIO(), dict.fromkeys(_WHOLE_NUMBERS, "DELTA_BINARY_PACKED")
    options: dict[str, Any] = {"use_dictionary": ["part"], "column_encoding": encodings, "write_statistics": False}
    with pq.ParquetWriter(sink, _SCHEMA, compression="zstd", write_page_checksum=True, **options) as writer:
        for first in range(0, len(rows), _BLOCK):
            writer.write_table(_table(rows[first : first + _BLOCK]), _BLOCK)
    data = sink.getvalue()
    return EntriesFile(sha256=atomic_files.sha256(data), count=len(rows)), data


def decode(data: bytes, count: int) -> EntryRows:
    """The inverse of `encode`. ValueError or OSError if the bytes are not `count` entries in ascending order."""
    file = pq.ParquetFile(pa.BufferReader(data), page_checksum_verification=True)
    if not file.schema_arrow.equals(_SCHEMA) or file.metadata.num_rows != count:
        raise ValueError("not a table of entries, or another number of them")
    numbers = [np.empty(count, dtype=np.int64) for _ in range(4)]
    rows = EntryRows(numbers[0], np.empty((count, 32), dtype=np.uint8), *numbers[1:])
    for first, table in _blocks(file):
        if any(column.null_count for column in table.columns):
            raise ValueError("an entry has no value")
        part = table["part"].combine_chunks()
        places = np.array([CODED.index(name) for name in part.dictionary.to_pylist()], dtype=np.int64)
        block = slice(first, first + len(table))
        rows.code[block] = codes_of(places[part.indices.to_numpy()], table["number"].to_numpy())
        rows.sha256[block] = _digests(table["sha256"].combine_chunks())
        for column, name in ((rows.size, "bytes"), (rows.first, "first"), (rows.samples, "count")):
            column[block] = table[name].to_numpy()
    pa.default_memory_pool().release_unused()  # what the blocks took
    if not rows.whole:
        raise ValueError("the entries are not in ascending order, or a number is not one of an entry")
    return rows


def _table(rows: EntryRows) -> pa.Table:
    digests = pa.py_buffer(np.ascontiguousarray(rows.sha256))
    part = pa.DictionaryArray.from_arrays(pa.array(rows.part.astype(np.int8)), list(CODED))
    sha256 = pa.FixedSizeBinaryArray.from_buffers(pa.binary(32), len(rows), [None, digests])
    return pa.table([part, rows.number, sha256, rows.size, rows.first, rows.samples], schema=_SCHEMA)


def _blocks(file: pq.ParquetFile) -> Iterator[tuple[int, pa.Table]]:
    """The row groups in turn, each with the number of its first row."""
    first = 0
    for group in range(file.num_row_groups):
        table = file.read_row_group(group, use_threads=False)
        yield first, table
        first += len(table)


def _digests(column: Any) -> np.ndarray:
    """(n, 32) bytes of a column of SHA-256."""
    data = cast("Any", column).buffers()[1]
    return np.frombuffer(data, dtype=np.uint8).reshape(-1, 32)[column.offset : column.offset + len(column)]
