"""Store: keeps the data files of a run folder and their entries in the manifest consistent."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from rvjax.cores import cores
from rvjax.errors import DamagedError, FolderError, RvjaxError
from rvjax.run_folder import atomic_files
from rvjax.run_folder.data_file import DataFile, recognised
from rvjax.run_folder.entries import EntryRows
from rvjax.run_folder.entry import PARTS, Entry, Key, Part
from rvjax.run_folder.journal import NAME as JOURNAL
from rvjax.run_folder.journal import Journal, entries_files, head_of
from rvjax.run_folder.manifest import NAME, Head, Manifest, digest
from rvjax.run_folder.parquet import same_table
from rvjax.run_folder.stock import compare


class Store:
    """The data files of a run folder, their manifest, and the lock: only the process that holds the lock may write."""

    def __init__(self, root: Path, journal: Journal, manifest: Manifest) -> None:
        self.root, self.manifest = root, manifest
        self._journal = journal
        self._lock: int | None = None

    @classmethod
    def new(cls, root: Path, head: Head) -> Store:
        """Locks a new folder; `fold` writes the manifest."""
        store = cls(root, Journal(root), Manifest(head))
        store._lock = atomic_files.lock(root)
        return store

    @classmethod
    def open(cls, root: Path) -> Store:
        """Reads manifest and journal. Errors as in `Journal.read`."""
        return cls(root, *Journal.read(root))

    @classmethod
    def rebuild(cls, root: Path) -> Store:
        """Rebuilds manifest and journal: the head from the undamaged file of the two, the entries from the data files. Damaged
        files go to `quarantine/`.

        FolderError if both are damaged, or if two whole files hold different samples of the same chunk.
        """
        store = cls.new(root, head_of(root))
        try:
            atomic_files.sweep(root, [""])
            store._adopt(name for name, _ in atomic_files.listing(root, PARTS) if Key.of(name))
            for name in (NAME, JOURNAL, *entries_files(root)):
                atomic_files.set_aside(root, name)
            store.fold()
        except BaseException:
            store.release()
            raise
        return store

    @property
    def claimed(self) -> bool:
        """Whether this process holds the lock."""
        return self._lock is not None

    def keys(self, part: Part) -> Iterator[Key]:
        """The keys of a part in ascending order."""
        return (Key(part, int(number)) for number in self.manifest.entries.of_part(part).number)

    def claim(self) -> None:
        """Takes the lock and reads the folder again if it was changed. UsageError if another process holds the lock."""
        if self._lock is None:
            lock = atomic_files.lock(self.root)
            try:
                if not self._journal.current:
                    self._journal, self.manifest = Journal.read(self.root)
                self.fold()
            except BaseException:
                os.close(lock)
                raise
            self._lock = lock

    def release(self) -> None:
        """Releases the lock."""
        self._journal.close()
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def fold(self) -> None:
        """Writes the manifest with all entries, and an empty journal."""
        self._journal.fold(self.manifest)

    def take_all(self, files: Iterable[DataFile]) -> None:
        """Adds data files and writes those that no worker has: all are on the disk and in the journal on return.

        Their names are synced together before their lines are, so a durable line has its file. Until then each whole file is
        recognised by its name. FolderError if the folder has another table with the same key.
        """
        self.claim()
        entries, new = self.manifest.entries, dict[Key, Entry]()
        unsynced = set[Path]()
        for file in files:
            key = file.entry.key
            if existing := entries.get(key) or new.get(key):
                self._compare(existing, file)
                continue
            if file.data is None:
                self.verified(file.entry)
            else:
                file.put(self.root, durable=False)
                unsynced.add((self.root / file.entry.file).parent)
            new[key] = file.entry
        for folder in sorted(unsynced):
            with atomic_files.explained(folder):
                atomic_files.sync(folder)
        if not new:
            return
        if self._journal.due:
            self.fold()
        entries.update(new)  # first, so that `fold` has them even if `append` is interrupted
        try:
            self._journal.append(new.values())
        except RvjaxError:
            for key in new:
                del entries[key]
            raise

    def _compare(self, existing: Entry, file: DataFile) -> None:
        """FolderError if a data file holds another table than the committed one with its key."""
        data = self.verified(file.entry) if file.data is None else file.data
        if existing.sha256 != file.entry.sha256 and not same_table(self.verified(existing), data):
            raise _contradiction(self.root, existing, file.entry)

    def verified(self, entry: Entry) -> bytes:
        """The bytes of a data file; DamagedError if they are not the committed bytes."""
        return compared(self.root, entry.file, entry.sha256)

    def verify(self, entries: EntryRows) -> None:
        """Verifies many data files in parallel; errors as in `verified`."""

        def read(part: EntryRows) -> None:
            for entry in part:
                self.verified(entry)

        count = cores()
        with ThreadPoolExecutor(count) as threads:
            list(threads.map(read, (entries[first::count] for first in range(count))))

    def complaint(self, key: Key) -> str:
        """The error message of a damaged file; empty if the file is whole."""
        try:
            self.verified(self.manifest.entries[key])
        except DamagedError as error:
            return str(error)
        return ""

    def take_stock(self, requested: int, lanes: int) -> None:
        """Updates the entries to the files on the disk and to the requested samples. lanes: samples of a full chunk."""
        entries = self.manifest.entries
        atomic_files.sweep(self.root, ("", "figures"))
        absent, others = compare(entries.rows, atomic_files.listing(self.root, PARTS))
        for entry in absent:
            del entries[entry.key]
            atomic_files.set_aside(self.root, entry.file)
        self.manifest.head.samples = requested
        self._adopt(others)
        chunks = entries.of_part("samples")
        incomplete = chunks.number[chunks.samples < np.minimum(lanes, requested - chunks.first)].tolist()
        self.drop([Key(part, number) for part in ("samples", "envelopes") for number in incomplete])

    def drop(self, keys: Iterable[Key]) -> None:
        """Removes data files, first from the manifest and then from the disk."""
        entries = self.manifest.entries
        removed = [entries.pop(key) for key in keys if key in entries]
        if removed:
            self.fold()
        for entry in removed:
            with atomic_files.explained(self.root / entry.file):
                atomic_files.inside(self.root, entry.file).unlink(missing_ok=True)

    def set_aside(self, keys: Iterable[Key]) -> None:
        """Moves damaged files to `quarantine/` and removes them from the manifest."""
        damaged = list(keys)
        if damaged:
            self.claim()
            for key in damaged:
                atomic_files.set_aside(self.root, self.manifest.entries.pop(key).file)
            self.fold()

    def _adopt(self, names: Iterable[str]) -> None:
        """Adds the whole files of this run to the entries and moves all others to `quarantine/`.

        Of two files for the same chunk, the file with more samples is added: the other is from a run with fewer samples.
        """
        head, entries = self.manifest.head, self.manifest.entries
        identity = digest(head.identity)
        for name in names:
            entry = recognised(self.root, name, identity)
            existing = entries.get(entry.key) if entry else None
            if entry and existing and entry.count == existing.count and entry.sha256 != existing.sha256:
                raise _contradiction(self.root, existing, entry)
            if entry and entry.first + entry.count <= head.samples and (existing is None or existing.count < entry.count):
                entries[entry.key] = entry
            else:
                atomic_files.set_aside(self.root, name)


def compared(root: Path, name: str, sha256: str) -> bytes:
    """The bytes of a file in the run folder; DamagedError if the file is missing or has another SHA-256."""
    path = atomic_files.inside(root, name)
    advice = "`rvjax run` with the same --out moves it to quarantine/ and flies it again"
    if not atomic_files.exists(path):
        raise DamagedError(f"{path}: missing, but SHA-256 {sha256} was committed; {advice}")
    data = atomic_files.read(path)
    if (actual := atomic_files.sha256(data)) != sha256:
        raise DamagedError(f"{path}: damaged or edited: SHA-256 {sha256} was committed, but it is {actual}; {advice}")
    return data


def _contradiction(root: Path, existing: Entry, other: Entry) -> FolderError:
    return FolderError(
        f"{root / existing.file}: committed with SHA-256 {existing.sha256}, flown again it has {other.sha256}; the same "
        "identity must give the same bytes. Choose another folder with --out, and please report this"
    )
