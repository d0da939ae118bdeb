"""Store: the files of data of a run folder and the entries that say what they are, kept in line with each other."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from rvjax.cores import cores
from rvjax.errors import DamagedError, FolderError
from rvjax.run_folder import atomic_files
from rvjax.run_folder.data_file import DataFile, recognised
from rvjax.run_folder.journal import NAME as JOURNAL
from rvjax.run_folder.journal import Journal, head_of
from rvjax.run_folder.manifest import NAME, Entry, Head, Key, Manifest, Part, digest
from rvjax.run_folder.parquet import same_table

PARTS: tuple[Part, ...] = ("samples", "envelopes", "traces")
"""The folders of data."""


class Store:
    """One process at a time may change it: the one that has claimed it."""

    def __init__(self, root: Path, journal: Journal) -> None:
        self.root = root
        self._journal = journal
        self._lock: int | None = None

    @classmethod
    def new(cls, root: Path, head: Head) -> Store:
        """Claims a place where nothing is on the disk yet; `fold` puts it there."""
        store = cls(root, Journal(root, Manifest(head)))
        store._lock = atomic_files.lock(root)
        return store

    @classmethod
    def rebuild(cls, root: Path) -> Store:
        """Makes manifest and journal again: the head from whichever of them is whole, all else from the files of data. The
        damaged ones go to `quarantine/`.

        FolderError where neither is whole, or two whole files hold different samples of one chunk.
        """
        store = cls.new(root, head_of(root))
        try:
            store._adopt(name for name in atomic_files.listing(root, PARTS) if Key.of(name))
            for name in (NAME, JOURNAL):
                atomic_files.set_aside(root, name)
            store.fold()
        except BaseException:
            store.release()
            raise
        return store

    @property
    def head(self) -> Head:
        """What the run is; to be changed before `fold`."""
        return self._journal.manifest.head

    @property
    def entries(self) -> dict[Key, Entry]:
        """The files of data."""
        return self._journal.manifest.entries

    @property
    def claimed(self) -> bool:
        """Whether this process is the one that writes."""
        return self._lock is not None

    def keys(self, part: Part) -> list[Key]:
        """The files of a part, in ascending order."""
        return sorted(key for key in self.entries if key.part == part)

    def claim(self) -> None:
        """Makes this process the one that writes, from what is there now. UsageError where another one does."""
        if self._lock is None:
            lock = atomic_files.lock(self.root)
            try:
                if not self._journal.current:
                    self._journal = Journal.read(self.root)
                self.fold()
            except BaseException:
                os.close(lock)
                raise
            self._lock = lock

    def release(self) -> None:
        """Lets other processes write."""
        self._journal.close()
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def fold(self) -> None:
        """Puts everything into the manifest."""
        self._journal.fold()

    def take(self, file: DataFile) -> None:
        """Adds a file, written here unless it is in its place already: on the disk and in the journal when this returns.

        FolderError where another table is there for the same key.
        """
        self.claim()
        there = self.entries.get(file.entry.key)
        if there:
            data = self.verified(file.entry) if file.data is None else file.data
            if there.sha256 != file.entry.sha256 and not same_table(self.verified(there), data):
                raise FolderError(_alarm(self.root, there, file.entry))
            return
        if file.data is None:
            self.verified(file.entry)
        else:
            file.put(self.root)
        self._journal.add(file.entry)

    def verified(self, entry: Entry) -> bytes:
        """The bytes of a file; FolderError where they are not what was committed."""
        return compared(self.root, entry.file, entry.sha256)

    def verify(self, entries: Sequence[Entry]) -> None:
        """As `verified`, of many files, each core a part of them."""

        def read(part: Sequence[Entry]) -> None:
            for entry in part:
                self.verified(entry)

        count = cores()
        with ThreadPoolExecutor(count) as threads:
            list(threads.map(read, (entries[first::count] for first in range(count))))

    def complaint(self, key: Key) -> str:
        """What is wrong with a file; empty where nothing is."""
        try:
            self.verified(self.entries[key])
        except DamagedError as error:
            return str(error)
        return ""

    def take_stock(self, requested: int, lanes: int) -> None:
        """Brings the entries in line with the files that are there, and with the samples that are requested now."""
        found = atomic_files.listing(self.root, (*PARTS, "figures"))
        for key, entry in list(self.entries.items()):
            if found.pop(entry.file, None) != entry.bytes:
                del self.entries[key]
                atomic_files.set_aside(self.root, entry.file)
        self.head.samples = requested
        self._adopt(name for name in found if name.startswith(tuple(f"{part}/" for part in PARTS)))
        chunks = [self.entries[key] for key in self.keys("samples")]
        cut = [chunk.number for chunk in chunks if chunk.count < min(lanes, requested - chunk.first)]
        self.drop([Key(part, number) for part in ("samples", "envelopes") for number in cut])

    def drop(self, keys: Iterable[Key]) -> None:
        """Removes files, first from the manifest."""
        gone = [self.entries.pop(key) for key in keys if key in self.entries]
        if gone:
            self.fold()
        for entry in gone:
            with atomic_files.explained(self.root / entry.file):
                atomic_files.inside(self.root, entry.file).unlink(missing_ok=True)

    def set_aside(self, keys: Iterable[Key]) -> None:
        """Takes damaged files out of the way and out of the manifest."""
        damaged = list(keys)
        if damaged:
            self.claim()
            for key in damaged:
                atomic_files.set_aside(self.root, self.entries.pop(key).file)
            self.fold()

    def _adopt(self, names: Iterable[str]) -> None:
        """Takes in the files that are whole and of this run; the others are set aside. Of two for one chunk, the one with more
        samples is taken: the other was cut short when fewer were requested."""
        identity = digest(self.head.identity)
        for name in names:
            entry = recognised(self.root, name, identity)
            there = self.entries.get(entry.key) if entry else None
            if entry and there and entry.count == there.count and entry.sha256 != there.sha256:
                raise FolderError(_alarm(self.root, there, entry))
            if entry and entry.first + entry.count <= self.head.samples and (there is None or there.count < entry.count):
                self.entries[entry.key] = entry
            else:
                atomic_files.set_aside(self.root, name)


def compared(root: Path, name: str, sha256: str) -> bytes:
    """The bytes of a file in the run folder; FolderError where their SHA-256 is another one."""
    path = atomic_files.inside(root, name)
    advice = "`rvjax run` with the same --out sets it aside and flies it again"
    if not atomic_files.exists(path):
        raise DamagedError(f"{path}: missing, but SHA-256 {sha256} was committed; {advice}")
    data = atomic_files.read(path)
    if (found := atomic_files.sha256(data)) != sha256:
        raise DamagedError(f"{path}: damaged or edited: SHA-256 {sha256} was committed, {found} is there; {advice}")
    return data


def _alarm(root: Path, there: Entry, other: Entry) -> str:
    return (
        f"{root / there.file}: committed with SHA-256 {there.sha256}, flown again it has {other.sha256}; the same "
        "identity must give the same bytes. Choose another folder with --out, and please report this"
    )
