"""Extract: the columns of the requirements, of all samples in a single file, so that judging a folder again is fast.

It is written with the report. It is used only if its SHA-256 is in `SHA256SUMS` and its metadata has the digest of the chunks of
the folder.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from rvjax.run_folder.entries import EntryRows
from rvjax.run_folder.named_arrays import Record

NAME = "judged.parquet"
MOST = 5_000_000
"""The largest number of samples of an extract."""

_CHUNKS = b"rvjax.chunks"


class Extract:
    """Collects the columns, chunk by chunk, in any order."""

    def __init__(self) -> None:
        self._parts: dict[int, pa.Table] = {}
        self.n = 0
        """The number of samples that were added."""

    def add(self, chunk: int, frame: pd.DataFrame, names: Sequence[str]) -> None:
        """Adds the columns of a chunk. With more than `MOST` samples the extract is dropped."""
        self.n += len(frame)
        if self.n > MOST:
            self._parts.clear()
            return
        columns = {name: pa.array(frame[name].to_numpy()) for name in ("sample", *names)}
        self._parts[chunk] = pa.table({"outcome": pa.array(frame["outcome"]).dictionary_encode(), **columns})

    def merge(self, other: Extract) -> None:
        """Adds the chunks of another extract; no chunk may be in both."""
        self.n += other.n
        self._parts |= other._parts
        if self.n > MOST:
            self._parts.clear()

    def record(self) -> Record:
        """All of it, for `Extract.of`."""
        chunks = sorted(self._parts)
        sizes = {"chunk": np.array(chunks, np.int64), "size": np.array([len(self._parts[chunk]) for chunk in chunks], np.int64)}
        arrays: dict[str, pa.Array] = {}
        if chunks:
            whole = pa.concat_tables([_plain(self._parts[chunk]) for chunk in chunks]).combine_chunks()
            arrays = {name: whole[name].chunk(0) for name in whole.column_names}
        return Record.joined({"chunks": Record.of_numbers(sizes), "columns": Record({}, arrays)}, n=self.n)

    @classmethod
    def of(cls, record: Record, names: Sequence[str]) -> Extract:
        """The extract of a record, with these columns; ValueError, KeyError or TypeError if the record contradicts itself."""
        extract, chunks = cls(), record.part("chunks")
        extract.n = int(record.document["n"])
        numbers, sizes = chunks.numbers("chunk").tolist(), chunks.numbers("size")
        behind = np.cumsum(sizes)
        whole = pa.table(record.part("columns").arrays)
        if whole.num_rows != sizes.sum() or np.any(sizes <= 0):
            raise ValueError("an extract of other chunks")
        if numbers and {*whole.column_names} != {"outcome", "sample", *names}:
            raise ValueError(f"an extract of {whole.column_names}; accepted: sample, outcome, {', '.join(names)}")
        for number, size, end in zip(numbers, sizes.tolist(), behind.tolist(), strict=True):
            part = whole.slice(end - size, size)
            outcome = part["outcome"].dictionary_encode()
            extract._parts[number] = part.set_column(part.schema.get_field_index("outcome"), "outcome", outcome)
        return extract

    def encoded(self, chunks: EntryRows) -> bytes | None:
        """The file as bytes; None unless all of these chunks were added."""
        if not self._parts or sorted(self._parts) != chunks.number.tolist():
            return None
        whole = pa.concat_tables([self._parts[number] for number in sorted(self._parts)]).unify_dictionaries().combine_chunks()
        whole = whole.replace_schema_metadata({_CHUNKS: chunks.digest.encode()})
        sink = pa.BufferOutputStream()
        dictionary: Any = ["outcome"]
        pq.write_table(whole, sink, compression="zstd", use_dictionary=dictionary, write_page_checksum=True)
        return sink.getvalue().to_pybytes()


def _plain(part: pa.Table) -> pa.Table:
    """The columns of a chunk with the outcome as texts."""
    outcome = part["outcome"]
    return part.set_column(part.schema.get_field_index("outcome"), "outcome", outcome.cast(outcome.type.value_type))


def decoded(data: bytes, chunks: EntryRows, names: Sequence[str]) -> tuple[pd.DataFrame, list[int]] | None:
    """The columns of all samples and the first row of each chunk; None if the file is of other chunks or lacks a column."""
    try:
        file = pq.ParquetFile(pa.BufferReader(data), page_checksum_verification=True)
        schema = file.schema_arrow
        if (schema.metadata or {}).get(_CHUNKS, b"").decode() != chunks.digest or not {*names} <= {*schema.names}:
            return None
        frame = file.read(["sample", "outcome", *names]).to_pandas(strings_to_categorical=True)
    except (pa.ArrowException, OSError):
        return None
    begins = np.concatenate([[0], np.cumsum(chunks.samples)[:-1]])
    return frame, begins.tolist()
