"""Tables as Parquet bytes: every column has its unit and description, every page its checksum.

zstd compression, floats split by byte stream (bit-exact, including NaN and infinities). The same table gives the same bytes.
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
"""The metadata key of a data file for the digest of its run's identity."""


def encode(table: pd.DataFrame | pa.Table, columns: Mapping[str, Column], identity: str = "") -> bytes:
    """The table as Parquet, with unit, description and better direction in the metadata of each field.

    identity: digest of the run's identity. ValueError if a column has no description in `columns`.
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
    """The inverse of `encode`; pyarrow.ArrowInvalid or OSError if the bytes are not such a table."""
    arrow = pq.read_table(pa.BufferReader(data), page_checksum_verification=True)
    columns = {field.name: _column(field) for field in arrow.schema}
    return arrow.to_pandas(), columns


def some_of(data: bytes, names: Sequence[str]) -> pa.Table:
    """The columns `names` of a table; errors as in `decode`, KeyError if a column is missing."""
    file = pq.ParquetFile(pa.BufferReader(data), page_checksum_verification=True)
    table = file.read(list(names), use_threads=False)
    if missing := [name for name in names if name not in table.column_names]:
        raise KeyError(missing[0])
    return table.select(list(names)).replace_schema_metadata(None)


def same_table(first: bytes, second: bytes) -> bool:
    """Whether two encoded tables have the same values, bit for bit; errors as in `decode`."""
    return _bits(first) == _bits(second)


def _bits(data: bytes) -> dict[str, Any]:
    columns = {name: series.to_numpy() for name, series in decode(data)[0].items()}
    return {str(name): x.tolist() if x.dtype == object else (x.dtype, x.tobytes()) for name, x in columns.items()}


def samples_of(data: bytes) -> tuple[str, NDArray[np.int64] | None]:
    """The digest of the run's identity (empty if missing) and the column `sample` (None if missing); errors as in `decode`."""
    file = pq.ParquetFile(pa.BufferReader(data), page_checksum_verification=True)
    identity = (file.schema_arrow.metadata or {}).get(IDENTITY, b"").decode()
    numbered = "sample" in file.schema_arrow.names
    return identity, file.read(["sample"])["sample"].to_numpy() if numbered else None


def _metadata(column: Column) -> dict[str, str]:
    required = {"unit": column.unit, "description": column.description, "better": column.better}
    return required | {name: text for name, text in (("kind", column.kind), ("law", column.law)) if text}


def _column(field: pa.Field) -> Column:
    text = {key.decode(): value.decode() for key, value in (field.metadata or {}).items()}
    return Column(field.name, *(text.get(name, "") for name in ("unit", "description", "better", "kind", "law")))
