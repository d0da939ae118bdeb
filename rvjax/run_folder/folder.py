"""RunFolder: stores the chunks of a run and returns them as tables; manifest and journal list its data files.

A data file counts only if it is listed and its SHA-256 matches. When a stopped run is resumed, all other files are checked:
temporary files are removed, whole files of this run are added (their names contain their SHA-256), and the others are moved to
`quarantine/`. Only a single process may write at a time.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import pandas as pd
import pyarrow as pa

from rvjax.campaign.named_files import INPUTS
from rvjax.campaign.source import Source
from rvjax.columns import OUTCOMES, Column
from rvjax.cores import cores
from rvjax.errors import DamagedError, FolderError, IncompleteError, UsageError
from rvjax.places import Place
from rvjax.run_folder import atomic_files, checksums, input_files, verdict_columns
from rvjax.run_folder.data_file import DataFile
from rvjax.run_folder.entries import EntryRows, neighbours
from rvjax.run_folder.entry import Entry, Key, Part
from rvjax.run_folder.made_files import CAMPAIGN, MadeFiles
from rvjax.run_folder.manifest import NAME as MANIFEST
from rvjax.run_folder.manifest import Audited, Head, differences, digest, plain
from rvjax.run_folder.parquet import decode, some_of
from rvjax.run_folder.run_description import RunDescription
from rvjax.run_folder.samples_table import Account, Samples, check_chunk, join
from rvjax.run_folder.storage import LEASE
from rvjax.run_folder.storages import storage_of
from rvjax.run_folder.store import Store, compared

BASELINES = "baselines"
"""The folder with the run folders of the baseline controllers, which flew the same draws."""

Table = tuple[pd.DataFrame, dict[str, Column]]


class RunFolder(MadeFiles):
    """A run folder, open for reading, and for writing by a single process at a time; leaving the context closes it.

    Use `create`, `open` or `resume` to get a RunFolder. path: the folder.
    """

    def __init__(self, store: Store) -> None:
        super().__init__(store.storage)
        self._store = store

    @classmethod
    def create(cls, path: str | Place, run: RunDescription) -> Self:
        """Makes a new run folder with the campaign and its input files, without data.

        FolderError if the folder exists and is not empty or cannot be written, UsageError if another process writes there.
        """
        storage, text = storage_of(path), run.campaign_text.encode()
        storage.make()
        head = Head(
            name=run.name,
            samples=run.samples,
            identity=plain(run.identity),
            provenance=plain(run.provenance),
            campaign=atomic_files.sha256(text),
        )
        store = Store.new(storage, head)
        try:
            expected = (CAMPAIGN, storage.log.name, LEASE, *([] if input_files.foreign(storage, run.inputs) else [INPUTS]))
            if any(name not in expected for name in storage.names()):
                raise FolderError(f"{storage.place}: there already and not empty; resume it, or choose another folder with --out")
            for _ in storage.listing([""]):
                pass  # it removes what a stopped process left unfinished
            storage.replace(CAMPAIGN, text)
            head.inputs = input_files.write(storage, run.inputs)
            store.fold()
        except BaseException:
            store.release()
            raise
        return cls(store)

    @classmethod
    def open(cls, path: str | Place) -> Self:
        """Opens a run folder.

        FolderError if it is not a run folder or its manifest or journal is damaged. Other files are verified when they are read.
        """
        return cls(Store.open(storage_of(path)))

    @classmethod
    def resume(cls, path: str | Place, run: RunDescription, lanes: int) -> Self:
        """Opens a run folder to fly the samples that it lacks. lanes: samples of a full chunk.

        Name, provenance and campaign file of the run replace those in the folder. The names and sizes of all files are checked: a
        file of another size goes to `quarantine/` and counts as missing, a file that is not in the manifest is added. Contents
        are verified when they are read (`read_valid_chunks`). If the number of samples grows, a last chunk of fewer than `lanes`
        samples is flown again.
        FolderError if the identity differs (it names the differences), UsageError if more samples were requested before or
        another process writes there.
        """
        folder = cls.open(path)
        if differing := differences(folder.identity, run.identity):
            lines = "\n".join(differing)
            raise FolderError(f"{path}: belongs to another run; choose another folder with --out. The differences are\n{lines}")
        if run.samples < folder.requested:
            raise UsageError(
                f"{path}: {folder.requested} samples were requested before, now {run.samples}; "
                f"resume with --samples {folder.requested} or more, or choose another folder with --out"
            )
        store = folder._store
        store.claim()
        try:
            store.take_stock(run.samples, lanes)
            started = {key: folder.provenance[key] for key in ("started",) if key in folder.provenance}
            text = run.campaign_text.encode()
            store.storage.replace(CAMPAIGN, text)
            head = store.manifest.head
            head.name, head.campaign = run.name, atomic_files.sha256(text)
            head.provenance = {**plain(run.provenance), **started}
            head.inputs = input_files.write(store.storage, run.inputs)
            store.fold()
        except BaseException:
            store.release()
            raise
        return folder

    @classmethod
    def rebuild(cls, path: str | Place) -> Self:
        """Rebuilds a damaged manifest or journal from the data files, which are verified by their names.

        FolderError if both manifest and journal are damaged.
        """
        return cls(Store.rebuild(storage_of(path)))

    @staticmethod
    def begun(path: str | Place) -> bool:
        """Whether there is a run folder, or the rest of one without a manifest, which may be rebuilt."""
        storage = storage_of(path)
        return storage.exists(MANIFEST) or bool(storage.log.read(""))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Folds the journal into the manifest and releases the lock."""
        try:
            if self._store.claimed:
                self._store.fold()
        finally:
            self._store.release()

    @property
    def name(self) -> str:
        """The campaign's name."""
        return self._store.manifest.head.name

    @property
    def identity(self) -> dict[str, Any]:
        """Everything that determines the flights."""
        return self._store.manifest.head.identity

    @property
    def digest(self) -> str:
        """The digest of the identity, which every data file contains."""
        return digest(self.identity)

    @property
    def provenance(self) -> dict[str, Any]:
        """When, where and how the run was started."""
        return self._store.manifest.head.provenance

    @property
    def audit(self) -> Audited | None:
        """The result of the audit before the first flight; None if it was not recorded."""
        return self._store.manifest.head.audit

    @property
    def timings(self) -> dict[str, Any]:
        """`timings` with the seconds of the phases of the run, if they were recorded; else nothing."""
        return {name: self.provenance[name] for name in ("timings",) if name in self.provenance}

    def keep_timings(self, timings: Mapping[str, Any]) -> None:
        """Records the seconds of the phases of the run; on the disk when the folder is closed."""
        self._store.claim()
        self.provenance["timings"] = plain(timings)

    def keep_audit(self, audit: Audited) -> None:
        """Records the result of the audit, replacing an older result: on the disk on return."""
        self._store.claim()
        self._store.manifest.head.audit = audit
        self._store.fold()

    @property
    def requested(self) -> int:
        """The number of requested samples."""
        return self._store.manifest.head.samples

    def grow(self, samples: int) -> None:
        """Requests more samples; all chunks so far must be complete. On the disk on return."""
        self._store.claim()
        self._store.manifest.head.samples = samples
        self._store.fold()

    @property
    def chunks(self) -> EntryRows:
        """The entries of the finished chunks in ascending order: a sequence, and columns for many chunks."""
        return self._store.manifest.entries.of_part("samples")

    def missing(self, chunk_count: int, envelopes: int = 0) -> list[int]:
        """The chunks of 0 .. chunk_count - 1 that are not finished. envelopes: the first chunks that need an envelope, too."""
        envelopes, entries = min(envelopes, chunk_count), self._store.manifest.entries
        finished = entries.of_part("samples").present(chunk_count)
        finished[:envelopes] &= entries.of_part("envelopes").present(envelopes)
        return np.flatnonzero(~finished).tolist()

    def campaign_text(self) -> str:
        """The text of the campaign file. It and the input files are verified; DamagedError if any was changed."""
        text = compared(self._storage, CAMPAIGN, self._store.manifest.head.campaign).decode()
        if messages := input_files.complaints(self._storage, self._store.manifest.head.inputs):
            raise DamagedError("\n".join(messages))
        return text

    def campaign_source(self) -> Path | Source:
        """The campaign file for `rvjax.campaign.load`, verified with its input files; errors as in `campaign_text`."""
        self.campaign_text()
        return self._storage.campaign(CAMPAIGN, self._store.manifest.head.inputs)

    def take(self, file: DataFile) -> None:
        """Adds a data file and writes it unless a worker has: on the disk and in the journal on return.

        Errors as in `take_all`.
        """
        self.take_all([file])

    def take_all(self, files: Iterable[DataFile]) -> None:
        """As `take` for many files, which are synced together: much less waiting for the disk than for each by itself.

        A process that stops before this returns leaves some of the files, each whole; the same command takes them in when it
        resumes. FolderError if the folder has another table for the same chunk, IncompleteError if the disk fails. Files that
        were committed before stay.
        """
        self._store.take_all(files)

    def commit(self, chunk: int, table: pd.DataFrame | pa.Table, columns: Mapping[str, Column]) -> None:
        """Adds a finished chunk.

        table: a row per sample with consecutive numbers; `columns` describes every column except `sample` and `outcome`.
        ValueError if the table is different; other errors as in `take`.
        """
        check_chunk(chunk, np.asarray(table["sample"]), np.asarray(table["outcome"]))
        self._add(Key("samples", chunk), table, columns)

    def tables(self, chunks: Iterable[int] | None = None) -> Iterator[tuple[int, pd.DataFrame, dict[str, Column]]]:
        """Number, table and columns of finished chunks, by default of all, in turn. All files are verified.

        FolderError if a file is missing or damaged.
        """
        for key in self._store.keys("samples") if chunks is None else [Key("samples", chunk) for chunk in chunks]:
            yield (key.number, *self._table(key))

    def columns(self) -> dict[str, Column]:
        """The columns of the samples table; IncompleteError if no chunk is finished."""
        for _, _, columns in self.tables(self.chunks[:1].number.tolist()):
            return columns
        raise IncompleteError(f"{self.path}: no chunk is finished yet; fly it with `rvjax run` and the same --out")

    def some(self, names: Sequence[str]) -> Iterator[tuple[int, pd.DataFrame, list[int]]]:
        """The columns `names` of all finished chunks, verified, in groups of consecutive chunks.

        Each group: the number of its first chunk, the table, and the first row of each chunk. FolderError as in `tables`, or if a
        column is missing.
        """
        with ThreadPoolExecutor(cores()) as threads:
            for entries in neighbours(self.chunks):
                parts = list(threads.map(lambda entry: self._some(entry, names), entries))
                begins = np.concatenate([[0], np.cumsum([len(part) for part in parts])])
                yield entries[0].number, pa.concat_tables(parts).to_pandas(strings_to_categorical=True), begins[:-1].tolist()

    def extracted(self, names: Sequence[str]) -> list[tuple[int, pd.DataFrame, list[int]]]:
        """As `some`, in a single group, from the extract that was written with the report. Chunks are verified, but not decoded.

        Empty if there is no extract with these chunks and columns, or if the samples have gaps.
        """
        data, chunks = checksums.verified(self._storage, verdict_columns.NAME), self.chunks
        extract = None if data is None else verdict_columns.decoded(data, chunks, names)
        if extract is None or not len(chunks) or not chunks.contiguous:
            return []
        self._store.verify(chunks)
        return [(chunks[0].number, *extract)]

    def read_valid_chunks(self, chunks: Iterable[int]) -> Iterator[tuple[int, pd.DataFrame, dict[str, Column]]]:
        """As `tables`, without damaged chunks: they are moved to `quarantine/` and count as missing."""
        damaged: list[Key] = []
        for chunk in chunks:
            try:
                table = self._table(Key("samples", chunk))
            except DamagedError:
                damaged.append(Key("samples", chunk))
                continue
            yield (chunk, *table)
        self._store.set_aside(damaged)

    def samples(self) -> Samples:
        """All samples of the finished chunks, verified, in ascending order, in memory.

        FolderError if a file is missing or damaged, or if chunks contradict each other. IncompleteError if no chunk is finished.
        """
        if not len(self.chunks):
            raise IncompleteError(f"{self.path}: no chunk is finished yet; fly it with `rvjax run` and the same --out")
        return join(
            {self._store.manifest.entries[key].file: self._table(key) for key in self._store.keys("samples")}, self.requested
        )

    def account(self) -> Account:
        """The outcomes of the requested samples, and how many are missing. FolderError if a sample is there twice."""
        chunks = self.chunks
        spans = chunks.those(np.argsort(chunks.first, kind="stable"))
        if (spans.first[:-1] + spans.samples[:-1] > spans.first[1:]).any():
            raise FolderError(f"{self.path}: chunks share samples; fly the campaign again with another --out")
        counts = Counter[str]()
        for _, frame, _ in self.tables():
            counts.update(frame["outcome"].tolist())
        missing = self.requested - chunks.total
        return Account(self.requested, *(counts[outcome] for outcome in OUTCOMES), missing=missing)

    def write_traces(self, traces: Mapping[int, Table]) -> None:
        """Writes traces by sample: each with a row per step and the meaning of its columns."""
        self.take_all([DataFile.of(Key("traces", sample), *trace, self.digest) for sample, trace in traces.items()])

    def drop_traces(self, samples: Iterable[int]) -> None:
        """Removes traces."""
        self._store.claim()
        self._store.drop([Key("traces", sample) for sample in samples])

    def trace_samples(self) -> list[int]:
        """The samples whose traces are kept."""
        return self._store.manifest.entries.of_part("traces").number.tolist()

    def trace(self, sample: int) -> pd.DataFrame:
        """The trace of a sample, verified."""
        return self.trace_table(sample)[0]

    def trace_table(self, sample: int) -> Table:
        """The trace of a sample, verified, and its columns."""
        return self._table(Key("traces", sample))

    def write_envelope(self, chunk: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Writes the thinned histories of a chunk: a row per sample and instant, every column in `columns`."""
        self._add(Key("envelopes", chunk), frame, columns)

    def envelopes(self) -> pd.DataFrame:
        """The thinned histories of all chunks, verified; empty if there are none."""
        tables = [self._table(key)[0] for key in self._store.keys("envelopes")]
        return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()

    def quarantine_damaged(self, parts: Iterable[Part]) -> None:
        """Verifies all files of some parts and moves damaged files to `quarantine/`."""
        self._store.set_aside([key for part in parts for key in self._store.keys(part) if self._store.complaint(key)])

    def verify(self) -> None:
        """Verifies every file of the folder; FolderError names all files that are missing or damaged."""
        complaints = [complaint for key in self._store.manifest.entries if (complaint := self._store.complaint(key))]
        try:
            self.campaign_text()
        except FolderError as error:
            complaints.append(str(error))
        complaints += checksums.complaints(self._storage)
        if complaints:
            raise FolderError("\n".join(complaints))

    def _some(self, entry: Entry, names: Sequence[str]) -> pa.Table:
        data = self._store.verified(entry)
        try:
            return some_of(data, names)
        except (pa.ArrowException, OSError, KeyError) as error:
            raise DamagedError(f"{self.path / entry.file}: not a table of this run ({error}); fly the campaign again") from error

    def _table(self, key: Key) -> Table:
        entry = self._store.manifest.entries[key]
        data = self._store.verified(entry)
        try:
            return decode(data)
        except (pa.ArrowException, OSError) as error:
            raise DamagedError(f"{self.path / entry.file}: not a table ({error}); fly the campaign again") from error

    def _add(self, key: Key, table: pd.DataFrame | pa.Table, columns: Mapping[str, Column]) -> None:
        self.take(DataFile.of(key, table, columns, self.digest))
