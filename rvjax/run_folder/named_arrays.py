"""Record: named arrays and a document as bytes, and back, bit for bit.

The bytes are an Arrow IPC stream with one row: every column is a list, which holds one array. The document is JSON in the
metadata of the schema. Numbers keep their type and every bit, NaN and infinities too; nothing is pickled.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
from numpy.typing import NDArray

_DOCUMENT = b"rvjax.document"


@dataclass(frozen=True)
class Record:
    """document: what JSON can express. arrays: by name, of any lengths and types."""

    document: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, pa.Array] = field(default_factory=dict)

    @classmethod
    def of_numbers(cls, numbers: Mapping[str, NDArray[Any]], **document: Any) -> Record:
        """A record of NumPy arrays."""
        return cls(document, {name: pa.array(x) for name, x in numbers.items()})

    @classmethod
    def of_frame(cls, frame: pd.DataFrame) -> Record:
        """A record of a table with any index, which is dropped."""
        names = [str(name) for name in frame.columns]
        return cls({"names": names}, {str(place): pa.array(frame[name].to_numpy()) for place, name in enumerate(names)})

    @classmethod
    def joined(cls, parts: Mapping[str, Record], **document: Any) -> Record:
        """A record of records; `part` gives them back. The names of the parts have no slash."""
        arrays = {f"{name}/{inner}": array for name, part in parts.items() for inner, array in part.arrays.items()}
        return cls(document | {"parts": {name: part.document for name, part in parts.items()}}, arrays)

    def part(self, name: str) -> Record:
        """A record from `joined`; KeyError if it is not there."""
        start = f"{name}/"
        arrays = {key.removeprefix(start): array for key, array in self.arrays.items() if key.startswith(start)}
        return Record(self.document["parts"][name], arrays)

    def numbers(self, name: str, dtype: type[np.generic] = np.int64) -> NDArray[Any]:
        """A NumPy array of this type, read-only; KeyError if it is not there, ValueError if it has another type or gaps."""
        array = self.arrays[name]
        if array.null_count or array.type != pa.from_numpy_dtype(dtype):
            raise ValueError(f"{name}: {array.null_count} gaps and type {array.type}; accepted: {np.dtype(dtype)} without gaps")
        return array.to_numpy()

    def frame(self) -> pd.DataFrame:
        """The table from `of_frame`; ValueError if its columns have different lengths."""
        names = self.document["names"]
        return pa.table({name: self.arrays[str(place)] for place, name in enumerate(names)}).to_pandas()

    def encode(self) -> bytes:
        """The record as bytes; equal records give equal bytes."""
        arrays = {name: pa.LargeListArray.from_arrays([0, len(array)], array) for name, array in self.arrays.items()}
        document = json.dumps(self.document, allow_nan=False).encode()
        table = pa.table(arrays).replace_schema_metadata({_DOCUMENT: document})
        sink = pa.BufferOutputStream()
        with pa.ipc.new_stream(sink, table.schema) as stream:
            stream.write_table(table)
        return sink.getvalue().to_pybytes()

    @classmethod
    def decode(cls, data: bytes) -> Record:
        """The inverse of `encode`. ValueError (of which ArrowInvalid is one), KeyError, TypeError or OSError if the bytes are no
        record."""
        with pa.ipc.open_stream(pa.BufferReader(data)) as stream:
            table = stream.read_all()
        table.validate(full=True)
        document = json.loads(table.schema.metadata[_DOCUMENT])
        if not isinstance(document, dict):
            raise ValueError(f"the document is a {type(document).__name__}; accepted: an object")
        return cls(document, {name: table[name][0].values for name in table.column_names})
