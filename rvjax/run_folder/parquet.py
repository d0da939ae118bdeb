"""Tables as Parquet bytes: every column with its unit and meaning, every page with its checksum.

zstd, floats split by byte stream (bit-exact: NaN and infinities survive). The same table gives the same bytes.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from rvjax.columns import Column

IDENTITY = b"rvjax.execution.identity"
"""Where a file of data says of which run it is."""


def encode(table: pd.DataFrame | pa.Table, columns: Mapping[str, Column], identity: str = "") -> bytes:
    """The table as Parquet, unit, description and better direction in each field's metadata. identity: digest of the run's.

    ValueError where a column has no description in `columns`.
    """
    if isinstance(table, pd.DataFrame):
        table = pa.table({name: pa.array(table[name].to_numpy()) for name in table.columns})
    unknown = [name for name in table.column_names if name not in columns]
    if unknown:
        raise ValueError(f"columns without unit and description: {', '.join(unknown)}")
    fields = [pa.field(field.name, field.type, metadata=_metadata(columns[field.name])) for field in table.schema]
    run = {IDENTITY: identity.encode()} if identity else None
    arrow = pa.table(table.columns, schema=pa.schema(fields, metadata=run))
    floats: Any = [field.name for field in arrow.schema if pa.types.is_floating(field.type)]
    others: Any = [name for name in arrow.column_names if name not in floats]
    sink = io.BytesIO()
    pq.write_table(
        arrow,
        sink,
        compression="zstd",
        use_dictionary=others,
        use_byte_stream_split=floats,
        write_page_checksum=True,
    )
    return sink.getvalue()


def decode(data: bytes) -> tuple[pd.DataFrame, dict[str, Column]]:
    """The inverse of `encode`; pyarrow.ArrowInvalid or OSError where the bytes are not such a table."""
    arrow = pq.read_table(pa.BufferReader(data), page_checksum_verification=True)
    columns = {field.name: _column(field) for field in arrow.schema}
    return arrow.to_pandas(), columns


def some_of(data: bytes, names: Sequence[str]) -> pa.Table:
    """Some columns of a table; errors as in `decode`, KeyError where it lacks one."""
    file = pq.ParquetFile(pa.BufferReader(data), page_checksum_verification=True)
    found = file.read(list(names), use_threads=False)
    if missing := [name for name in names if name not in found.column_names]:
        raise KeyError(missing[0])
    return found.select(list(names)).replace_schema_metadata(None)


def same_table(one: bytes, other: bytes) -> bool:
    """Whether two tables hold the same, bit by bit, whoever encoded them; errors as in `decode`."""
    return _bits(one) == _bits(other)


def _bits(data: bytes) -> dict[str, Any]:
    columns = {name: series.to_numpy() for name, series in decode(data)[0].items()}
    return {str(name): x.tolist() if x.dtype == object else (x.dtype, x.tobytes()) for name, x in columns.items()}


def samples_of(data: bytes) -> tuple[str, NDArray[np.int64] | None]:
    """The digest of the run's identity ("" where there is none), and the column `sample` of a table that has one; errors as in
    `decode`."""
    file = pq.ParquetFile(pa.BufferReader(data), page_checksum_verification=True)
    identity = (file.schema_arrow.metadata or {}).get(IDENTITY, b"").decode()
    there = "sample" in file.schema_arrow.names
    return identity, file.read(["sample"])["sample"].to_numpy() if there else None


def _metadata(column: Column) -> dict[str, str]:
    told = {"unit": column.unit, "description": column.description, "better": column.better}
    return told | {name: text for name, text in (("kind", column.kind), ("law", column.law)) if text}


def _column(field: pa.Field) -> Column:
    text = {key.decode(): value.decode() for key, value in (field.metadata or {}).items()}
    return Column(field.name, *(text.get(name, "") for name in ("unit", "description", "better", "kind", "law")))
