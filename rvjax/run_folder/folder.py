"""RunFolder: chunks of samples come in, tables come out; manifest and journal say what belongs to it.

A file counts only once it is in one of them, and only while its SHA-256 matches. What a stopped run leaves besides is looked at
when the run goes on: temporary files are removed, a whole file of this run (its name says what it must hold) is taken in, any
other one is set aside. One process writes.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import pandas as pd
import pyarrow as pa

from rvjax.campaign.csv_files import INPUTS
from rvjax.columns import Column
from rvjax.cores import cores
from rvjax.errors import DamagedError, FolderError, IncompleteError, UsageError
from rvjax.run_folder import atomic_files, checksums, verdict_columns
from rvjax.run_folder import input_files as given
from rvjax.run_folder.data_file import DataFile
from rvjax.run_folder.journal import NAME as JOURNAL
from rvjax.run_folder.journal import Journal
from rvjax.run_folder.manifest import NAME as MANIFEST
from rvjax.run_folder.manifest import Audited, Entry, Head, Key, Part, differences, digest, json_bytes, neighbours, plain
from rvjax.run_folder.parquet import decode, some_of
from rvjax.run_folder.samples_table import OUTCOMES, Account, Samples, check_chunk, join
from rvjax.run_folder.store import PARTS, Store, compared

CAMPAIGN = "campaign.yaml"
"""The campaign as it was given, in a run folder."""
BASELINES = "baselines"
"""Folder with the run folders of the other controllers that flew the same draws."""

_DATA = {*PARTS, atomic_files.QUARANTINE, INPUTS, CAMPAIGN, MANIFEST, JOURNAL, checksums.NAME}
_NONE: Mapping[str, bytes] = {}

Table = tuple[pd.DataFrame, dict[str, Column]]


class RunFolder:
    """A run folder, open for reading, and for writing by one process at a time; leaving the context closes it.

    Get one from `create`, `open` or `resume`. `path` is the folder.
    """

    def __init__(self, path: Path, store: Store) -> None:
        self.path = path
        self._store = store
        self._made: dict[str, str] = {}

    @classmethod
    def create(
        cls,
        path: str | Path,
        identity: Mapping[str, Any],
        provenance: Mapping[str, Any],
        campaign_text: str,
        samples: int,
        name: str,
        inputs: Mapping[str, bytes] = _NONE,
    ) -> Self:
        """Makes a new run folder with the campaign as given, the files that it names, and no data.

        `identity`: everything the flights are a function of, `provenance`: what else is worth knowing; both JSON.
        FolderError where something is there already or the place cannot be written, UsageError where another process
        writes there.
        """
        root, text = Path(path), campaign_text.encode()
        with atomic_files.explained(root):
            root.mkdir(parents=True, exist_ok=True)
            atomic_files.sync(root.parent)
        told = {"name": name, "samples": samples, "identity": plain(identity), "provenance": plain(provenance)}
        store = Store.new(root, Head(**told, campaign=atomic_files.sha256(text)))
        try:
            with atomic_files.explained(root):
                ours = (CAMPAIGN, JOURNAL, *([] if given.foreign(root, inputs) else [INPUTS]))
                if any(name not in ours and not atomic_files.is_temporary(name) for name in os.listdir(root)):
                    raise FolderError(f"{root}: there already and not empty; resume it, or choose another with --out")
            atomic_files.listing(root, ())
            atomic_files.replace(root / CAMPAIGN, text)
            store.head.inputs = given.write(root, inputs)
            store.fold()
        except BaseException:
            store.release()
            raise
        return cls(root, store)

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Opens a run folder.

        FolderError where it is none or its manifest or journal is damaged. Other files are verified as they are read.
        """
        return cls(Path(path), Store(Path(path), Journal.read(Path(path))))

    @classmethod
    def resume(
        cls,
        path: str | Path,
        identity: Mapping[str, Any],
        provenance: Mapping[str, Any],
        campaign_text: str,
        samples: int,
        name: str,
        lanes: int,
        inputs: Mapping[str, bytes] = _NONE,
    ) -> Self:
        """Opens a run folder to fly what it lacks of `samples`.

        What is not part of the identity (name, requirements, provenance) is from now on what is given here. Names and sizes of
        all files are looked at: one that is missing or of another size counts as missing and goes to `quarantine/`, one that
        did not reach the manifest is taken in. Their contents are verified when they are read (`read_valid_chunks`). Where
        `samples` grows, a last chunk of fewer than `lanes` samples is flown again.
        FolderError where the identity differs (saying in what), UsageError where more samples were requested before or
        another process writes there.
        """
        folder = cls.open(path)
        if differing := differences(folder.identity, identity):
            what = "\n".join(differing)
            raise FolderError(f"{path}: belongs to another run; choose another with --out. They differ in\n{what}")
        if samples < folder.requested:
            raise UsageError(
                f"{path}: {folder.requested} samples were requested before, now {samples}; "
                f"go on with --samples {folder.requested} or more, or choose another folder with --out"
            )
        store = folder._store
        store.claim()
        try:
            store.take_stock(samples, lanes)
            started = {key: folder.provenance[key] for key in ("started",) if key in folder.provenance}
            text = campaign_text.encode()
            atomic_files.replace(folder.path / CAMPAIGN, text)
            head = store.head
            head.name, head.provenance, head.campaign = name, {**plain(provenance), **started}, atomic_files.sha256(text)
            head.inputs = given.write(folder.path, inputs)
            store.fold()
        except BaseException:
            store.release()
            raise
        return folder

    @classmethod
    def rebuild(cls, path: str | Path) -> Self:
        """Makes a damaged manifest or journal again from the files of data, which show by themselves whether they are whole.

        FolderError where neither manifest nor journal says any more what was flown.
        """
        return cls(Path(path), Store.rebuild(Path(path)))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Folds the journal into the manifest, and lets other processes write."""
        try:
            if self._store.claimed:
                self._store.fold()
        finally:
            self._store.release()

    @property
    def name(self) -> str:
        """The campaign's name."""
        return self._store.head.name

    @property
    def identity(self) -> dict[str, Any]:
        """Everything the flights are a function of."""
        return self._store.head.identity

    @property
    def digest(self) -> str:
        """The digest of the identity, which every file of data carries."""
        return digest(self.identity)

    @property
    def provenance(self) -> dict[str, Any]:
        """When, where and how the run was started."""
        return self._store.head.provenance

    @property
    def audit(self) -> Audited | None:
        """What was proved of the dispersions before the first flight; None where that was not kept."""
        return self._store.head.audit

    def keep_audit(self, audit: Audited) -> None:
        """Keeps what was proved, in place of an older proof: on the disk on return."""
        self._store.claim()
        self._store.head.audit = audit
        self._store.fold()

    @property
    def requested(self) -> int:
        """The number of samples asked for."""
        return self._store.head.samples

    def grow(self, samples: int) -> None:
        """Asks for more samples than before, all chunks so far being whole: on the disk on return."""
        self._store.claim()
        self._store.head.samples = samples
        self._store.fold()

    @property
    def chunks(self) -> tuple[Entry, ...]:
        """The finished chunks in order, each with its file and SHA-256."""
        return tuple(self._store.entries[key] for key in self._store.keys("samples"))

    def missing(self, chunk_count: int, envelopes: int = 0) -> list[int]:
        """The chunks of 0 .. chunk_count - 1 that are not finished; the first so many need an envelope, too."""
        parts: Mapping[int, tuple[Part, ...]] = dict.fromkeys(range(envelopes), ("samples", "envelopes"))
        there = self._store.entries
        return [n for n in range(chunk_count) if any(Key(part, n) not in there for part in parts.get(n, ("samples",)))]

    def campaign_text(self) -> str:
        """The campaign file as it was given; it and the files that it names verified."""
        text = compared(self.path, CAMPAIGN, self._store.head.campaign).decode()
        if found := given.complaints(self.path, self._store.head.inputs):
            raise DamagedError("\n".join(found))
        return text

    def take(self, file: DataFile) -> None:
        """Adds a file of data, written here unless it is in its place already: on the disk and in the journal on return.

        FolderError where another one is there for the same chunk, IncompleteError where the disk refuses; what was committed
        before stays.
        """
        self._store.take(file)

    def commit(self, chunk: int, table: pd.DataFrame | pa.Table, columns: Mapping[str, Column]) -> None:
        """Adds a finished chunk.

        `table`: one row per sample, consecutive numbers, every column in `columns` (except `sample`, `outcome`).
        ValueError where the table is not such a table; other errors as in `take`.
        """
        check_chunk(chunk, np.asarray(table["sample"]), np.asarray(table["outcome"]))
        self._add(Key("samples", chunk), table, columns)

    def tables(self, chunks: Iterable[int] | None = None) -> Iterator[tuple[int, pd.DataFrame, dict[str, Column]]]:
        """Number, table and columns of some finished chunks, by default of all, verified, one after the other.

        FolderError where a file is missing or damaged.
        """
        for key in self._store.keys("samples") if chunks is None else [Key("samples", chunk) for chunk in chunks]:
            yield (key.number, *self._table(key))

    def columns(self) -> dict[str, Column]:
        """The columns of the samples' table; IncompleteError where no chunk is finished."""
        for _, _, columns in self.tables(chunk.number for chunk in self.chunks[:1]):
            return columns
        raise IncompleteError(f"{self.path}: no chunk is finished yet; fly it with `rvjax run` and the same --out")

    def some(self, names: Sequence[str]) -> Iterator[tuple[int, pd.DataFrame, list[int]]]:
        """Some columns of all finished chunks, verified, many chunks at a time that have no gap between them: the first one's
        number, their table, and the row with which each of them begins. FolderError as of `tables`, or where a column lacks."""
        with ThreadPoolExecutor(cores()) as threads:
            for entries in neighbours(self.chunks):
                parts = list(threads.map(lambda entry: self._some(entry, names), entries))
                begins = np.concatenate([[0], np.cumsum([len(part) for part in parts])])
                yield entries[0].number, pa.concat_tables(parts).to_pandas(strings_to_categorical=True), begins[:-1].tolist()

    def extracted(self, names: Sequence[str]) -> list[tuple[int, pd.DataFrame, list[int]]]:
        """As `some`, all at once, out of the extract that the report has left; chunks are verified, but not decoded. Empty where
        there is none of these chunks and columns, or samples have gaps."""
        data, chunks = checksums.verified(self.path, verdict_columns.NAME), self.chunks
        found = None if data is None else verdict_columns.decoded(data, chunks, names)
        if found is None or len(list(neighbours(chunks, len(chunks)))) != 1:
            return []
        self._store.verify(chunks)
        return [(chunks[0].number, *found)]

    def read_valid_chunks(self, chunks: Iterable[int]) -> Iterator[tuple[int, pd.DataFrame, dict[str, Column]]]:
        """As `tables`; a chunk whose file is damaged is left out, set aside, and missing from then on."""
        damaged: list[Key] = []
        for chunk in chunks:
            try:
                found = self._table(Key("samples", chunk))
            except DamagedError:
                damaged.append(Key("samples", chunk))
                continue
            yield (chunk, *found)
        self._store.set_aside(damaged)

    def samples(self) -> Samples:
        """All samples of the finished chunks, verified, in ascending order: all of them in memory.

        FolderError where a file is missing or damaged, or chunks contradict each other. IncompleteError where no
        chunk is finished.
        """
        if not self.chunks:
            raise IncompleteError(f"{self.path}: no chunk is finished yet; fly it with `rvjax run` and the same --out")
        return join({self._store.entries[key].file: self._table(key) for key in self._store.keys("samples")}, self.requested)

    def account(self) -> Account:
        """How many of the requested samples ended how, and how many are missing; FolderError where one is there twice."""
        spans = sorted((entry.first, entry.first + entry.count) for entry in self.chunks)
        if any(behind > first for (_, behind), (first, _) in pairwise(spans)):
            raise FolderError(f"{self.path}: chunks share samples; fly the campaign again with another --out")
        counts = Counter[str]()
        for _, frame, _ in self.tables():
            counts.update(frame["outcome"].tolist())
        captured, not_settled, not_finite = (counts[outcome] for outcome in OUTCOMES)
        missing = self.requested - sum(entry.count for entry in self.chunks)
        return Account(self.requested, captured, not_settled, not_finite, missing)

    def write_trace(self, sample: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Keeps one sample's flight, one row per step, every column in `columns`."""
        self._add(Key("traces", sample), frame, columns)

    def drop_traces(self, samples: Iterable[int]) -> None:
        """Removes kept flights."""
        self._store.claim()
        self._store.drop([Key("traces", sample) for sample in samples])

    def trace_samples(self) -> list[int]:
        """The samples whose flights are kept."""
        return [key.number for key in self._store.keys("traces")]

    def trace(self, sample: int) -> pd.DataFrame:
        """A kept flight, verified."""
        return self._table(Key("traces", sample))[0]

    def write_envelope(self, chunk: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Keeps a chunk's thinned histories, one row per sample and instant, every column in `columns`."""
        self._add(Key("envelopes", chunk), frame, columns)

    def envelopes(self) -> pd.DataFrame:
        """The thinned histories of all chunks, verified; empty where none was kept."""
        tables = [self._table(key)[0] for key in self._store.keys("envelopes")]
        return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()

    def quarantine_damaged(self, parts: Iterable[Part]) -> None:
        """Reads files of envelopes or traces; damaged ones are set aside."""
        self._store.set_aside([key for part in parts for key in self._store.keys(part) if self._store.complaint(key)])

    def write_summary(self, summary: Mapping[str, Any]) -> Path:
        """Writes `summary.json`, strict JSON; numbers that are not finite become null."""
        return self.write_bytes("summary.json", json_bytes(summary))

    def write_text(self, name: str, text: str) -> Path:
        """Writes a text file (UTF-8) into the folder, atomically; bytes of a path that are no UTF-8 are spelt out."""
        return self.write_bytes(name, text.encode(errors="backslashreplace"))

    def write_bytes(self, name: str, data: bytes) -> Path:
        """Writes a file into the folder, atomically, over an older one; returns its path.

        For what can be made again from the data; `seal` notes their SHA-256 when all are there.
        FolderError where `name` leads out of the folder or names data.
        """
        path = atomic_files.inside(self.path, name)
        if path.relative_to(self.path).parts[0] in _DATA:
            raise FolderError(f"{path}: holds data of the run, which is never overwritten; accepted: another name")
        atomic_files.replace(path, data)
        self._made[path.relative_to(self.path).as_posix()] = atomic_files.sha256(data)
        return path

    def seal(self) -> None:
        """Notes the SHA-256 of every file that was written so."""
        checksums.seal(self.path, self._made)

    def verify(self) -> None:
        """Reads every file of the run and what was made from them; FolderError names all that are missing or damaged."""
        complaints = [complaint for key in sorted(self._store.entries) if (complaint := self._store.complaint(key))]
        try:
            self.campaign_text()
        except FolderError as error:
            complaints.append(str(error))
        complaints += checksums.complaints(self.path)
        if complaints:
            raise FolderError("\n".join(complaints))

    def _some(self, entry: Entry, names: Sequence[str]) -> pa.Table:
        data = self._store.verified(entry)
        try:
            return some_of(data, names)
        except (pa.ArrowException, OSError, KeyError) as error:
            raise DamagedError(f"{self.path / entry.file}: not a table of this run ({error}); fly the campaign again") from error

    def _table(self, key: Key) -> Table:
        entry = self._store.entries[key]
        data = self._store.verified(entry)
        try:
            return decode(data)
        except (pa.ArrowException, OSError) as error:
            raise DamagedError(f"{self.path / entry.file}: not a table ({error}); fly the campaign again") from error

    def _add(self, key: Key, table: pd.DataFrame | pa.Table, columns: Mapping[str, Column]) -> None:
        self.take(DataFile.of(key, table, columns, self.digest))
