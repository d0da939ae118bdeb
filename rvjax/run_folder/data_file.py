"""DataFile: a table as bytes with its manifest entry. The same table gives the same bytes and the same entry."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa

from rvjax.columns import Column
from rvjax.run_folder import atomic_files, parquet
from rvjax.run_folder.entry import Entry, Key
from rvjax.run_folder.samples_table import KEYS
from rvjax.run_folder.storage import Storage


class DataFile(NamedTuple):
    """entry: name, size and SHA-256. data: the bytes; None if a worker has written them to the run folder already."""

    entry: Entry
    data: bytes | None

    @classmethod
    def of(cls, key: Key, table: pd.DataFrame | pa.Table, columns: Mapping[str, Column], identity: str) -> DataFile:
        """Encodes a table. identity: digest of the run's identity. ValueError if a column has no description in `columns`."""
        known = columns if key.part == "traces" else {**KEYS, **columns}
        data = parquet.encode(table, known, identity)
        samples = np.array([key.number]) if key.part == "traces" else np.asarray(table["sample"])
        return cls(_entry(key, data, samples), data)

    def put(self, storage: Storage, durable: bool = True) -> DataFile:
        """Writes the bytes into a run folder. The first writer wins; all writers write the same bytes.

        durable: the file's name is on the disk on return; otherwise the caller must sync its folder.
        """
        if self.data is not None:
            name = self.entry.file
            if not storage.publish(name, self.data, durable):  # an existing file with this name and other bytes is damaged
                storage.set_aside(name)
                storage.publish(name, self.data, durable)
        return DataFile(self.entry, None)


def recognised(storage: Storage, file: str, identity: str) -> Entry | None:
    """The entry of a data file; None if the file is damaged or belongs to a run with another identity."""
    key = Key.of(file)
    data = storage.read(file)
    if key is None or key.file(atomic_files.sha256(data)) != file:
        return None
    try:
        run, samples = parquet.samples_of(data)
    except (pa.ArrowException, OSError):
        return None
    if key.part == "traces":
        samples = np.array([key.number])
    return _entry(key, data, samples) if run == identity and samples is not None and samples.size else None


def _entry(key: Key, data: bytes, samples: np.ndarray) -> Entry:
    digest = atomic_files.sha256(data)
    first, last = int(samples.min()), int(samples.max())
    return Entry(file=key.file(digest), sha256=digest, bytes=len(data), first=first, count=last - first + 1)
