"""Store: keeps the data files of a run folder and their entries in the manifest consistent."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from rvjax.cores import cores
from rvjax.errors import DamagedError, FolderError, RvjaxError
from rvjax.places import Place
from rvjax.run_folder import atomic_files
from rvjax.run_folder.data_file import DataFile, recognised
from rvjax.run_folder.entries import EntryRows
from rvjax.run_folder.entries_file import is_entries_file
from rvjax.run_folder.entry import PARTS, Entry, Key, Part
from rvjax.run_folder.journal import Journal, head_of
from rvjax.run_folder.manifest import NAME, Head, Manifest, digest
from rvjax.run_folder.parquet import same_table
from rvjax.run_folder.stock import compare
from rvjax.run_folder.storage import Storage, locked


class Store:
    """The data files of a run folder, their manifest, and the lock: only the process that holds the lock may write."""

    def __init__(self, storage: Storage, journal: Journal, manifest: Manifest) -> None:
        self.storage, self.manifest = storage, manifest
        self.claimed = False
        """Whether this process may write."""
        self._journal = journal

    @classmethod
    def new(cls, storage: Storage, head: Head) -> Store:
        """Locks a new folder; `fold` writes the manifest."""
        store = cls(storage, Journal(storage), Manifest(head))
        storage.lock()
        store.claimed = True
        return store

    @classmethod
    def open(cls, storage: Storage) -> Store:
        """Reads manifest and journal. Errors as in `Journal.read`."""
        return cls(storage, *Journal.read(storage))

    @classmethod
    def rebuild(cls, storage: Storage) -> Store:
        """Rebuilds manifest and journal: the head from the undamaged file of the two, the entries from the data files. Damaged
        files go to `quarantine/`.

        FolderError if both are damaged, or if two whole files hold different samples of the same chunk.
        """
        store = cls.new(storage, head_of(storage))
        try:
            others = [name for name, _ in storage.listing([""])]
            store._adopt(name for name, _ in storage.listing(PARTS) if Key.of(name))
            for name in others:
                if name == NAME or is_entries_file(name):
                    storage.set_aside(name)
            storage.log.set_aside()
            store.fold()
        except BaseException:
            store.release()
            raise
        return store

    def keys(self, part: Part) -> Iterator[Key]:
        """The keys of a part in ascending order."""
        return (Key(part, int(number)) for number in self.manifest.entries.of_part(part).number)

    def claim(self) -> None:
        """Takes the lock and reads the folder again if it was changed. UsageError if another process holds the lock."""
        if not self.claimed:
            with locked(self.storage):
                if not self._journal.current:
                    self._journal, self.manifest = Journal.read(self.storage)
                self.fold()
            self.claimed = True

    def release(self) -> None:
        """Releases the lock."""
        self._journal.close()
        self.storage.unlock()
        self.claimed = False

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
        unsynced: list[str] = []
        for file in files:
            key = file.entry.key
            if existing := entries.get(key) or new.get(key):
                self._compare(existing, file)
                continue
            if file.data is None:
                self.verified(file.entry)
            else:
                file.put(self.storage, durable=False)
                unsynced.append(file.entry.file)
            new[key] = file.entry
        self.storage.sync(unsynced)
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
            raise _contradiction(self.storage.place, existing, file.entry)

    def verified(self, entry: Entry) -> bytes:
        """The bytes of a data file; DamagedError if they are not the committed bytes."""
        return compared(self.storage, entry.file, entry.sha256)

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
        for _ in self.storage.listing(("", "figures")):
            pass  # it removes what a stopped process left unfinished
        absent, others = compare(entries.rows, self.storage.listing(PARTS))
        for entry in absent:
            del entries[entry.key]
            self.storage.set_aside(entry.file)
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
            self.storage.remove(entry.file)

    def set_aside(self, keys: Iterable[Key]) -> None:
        """Moves damaged files to `quarantine/` and removes them from the manifest."""
        damaged = list(keys)
        if damaged:
            self.claim()
            for key in damaged:
                self.storage.set_aside(self.manifest.entries.pop(key).file)
            self.fold()

    def _adopt(self, names: Iterable[str]) -> None:
        """Adds the whole files of this run to the entries and moves all others to `quarantine/`.

        Of two files for the same chunk, the file with more samples is added: the other is from a run with fewer samples.
        """
        head, entries = self.manifest.head, self.manifest.entries
        identity = digest(head.identity)
        for name in names:
            entry = recognised(self.storage, name, identity)
            existing = entries.get(entry.key) if entry else None
            if entry and existing and entry.count == existing.count and entry.sha256 != existing.sha256:
                raise _contradiction(self.storage.place, existing, entry)
            if entry and entry.first + entry.count <= head.samples and (existing is None or existing.count < entry.count):
                entries[entry.key] = entry
            else:
                self.storage.set_aside(name)


def compared(storage: Storage, name: str, sha256: str) -> bytes:
    """The bytes of a file in the run folder; DamagedError if the file is missing or has another SHA-256."""
    path = storage.place / name
    advice = "`rvjax run` with the same --out moves it to quarantine/ and flies it again"
    if not storage.exists(name):
        raise DamagedError(f"{path}: missing, but SHA-256 {sha256} was committed; {advice}")
    data = storage.read(name)
    if (actual := atomic_files.sha256(data)) != sha256:
        raise DamagedError(f"{path}: damaged or edited: SHA-256 {sha256} was committed, but it is {actual}; {advice}")
    return data


def _contradiction(root: Place, existing: Entry, other: Entry) -> FolderError:
    return FolderError(
        f"{root / existing.file}: committed with SHA-256 {existing.sha256}, flown again it has {other.sha256}; the same "
        "identity must give the same bytes. Choose another folder with --out, and please report this"
    )
