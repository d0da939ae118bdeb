"""LocalStorage: a run folder on a file system, with atomic files and a lock."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

from rvjax.run_folder import atomic_files
from rvjax.run_folder.refusals import leaves_no_folder

JOURNAL = "journal.jsonl"

MOST_LINES = 8_192
"""The number of lines after which a commit folds the journal into the manifest, so that both are read fast."""


class LocalLog:
    """The journal as a file to which lines are appended."""

    name = JOURNAL

    def __init__(self, path: Path) -> None:
        self.path = path
        self._handle: int | None = None
        self._length = 0

    def read(self, base: str) -> bytes:
        """As `Log.read`."""
        del base
        text = atomic_files.read(self.path) if atomic_files.exists(self.path) else b""
        self._length = len(text)
        return text

    def start(self, base: str, first: bytes) -> None:
        """As `Log.start`."""
        del base
        atomic_files.replace(self.path, first)
        self._length = len(first)

    def prepare(self) -> None:
        """As `Log.prepare`."""
        with atomic_files.explained(self.path):
            self._handle = os.open(self.path, os.O_WRONLY | os.O_APPEND)

    def append(self, lines: bytes) -> None:
        """As `Log.append`."""
        with atomic_files.explained(self.path):
            assert self._handle is not None
            try:
                if os.write(self._handle, lines) < len(lines):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                os.fsync(self._handle)
            except OSError:
                os.ftruncate(self._handle, self._length)  # removes incomplete lines
                raise
        self._length += len(lines)

    def seal(self) -> None:
        """As `Log.seal`: the lock of the folder sees to it."""

    def close(self) -> None:
        """As `Log.close`."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None

    def set_aside(self) -> None:
        """As `Log.set_aside`."""
        atomic_files.set_aside(self.path.parent, self.name)


class LocalStorage:
    """The files below a folder of this machine."""

    def __init__(self, root: Path) -> None:
        self.place = root
        self.log = LocalLog(root / JOURNAL)
        self._lock: int | None = None

    @property
    def most_lines(self) -> int:
        """As `Storage.most_lines`."""
        return MOST_LINES

    def check(self) -> None:
        """As `Storage.check`."""
        atomic_files.check_folder(self.place)

    def make(self) -> None:
        """As `Storage.make`."""
        with atomic_files.explained(self.place):
            self.place.mkdir(parents=True, exist_ok=True)
            atomic_files.sync(self.place.parent)

    def names(self) -> list[str]:
        """As `Storage.names`."""
        with atomic_files.explained(self.place):
            return [name for name in os.listdir(self.place) if not atomic_files.is_temporary(name)]

    def below(self, folder: str) -> list[str]:
        """As `Storage.below`."""
        root, names = self.place / folder, list[str]()
        for place, _, files in os.walk(root):
            finished = [name for name in files if not atomic_files.is_temporary(name)]
            names += [(Path(place) / name).relative_to(root).as_posix() for name in finished]
        return names

    def exists(self, name: str) -> bool:
        """As `Storage.exists`."""
        return atomic_files.exists(self.place / name)

    def read(self, name: str) -> bytes:
        """As `Storage.read`."""
        return atomic_files.read(atomic_files.inside(self.place, name))

    def replace(self, name: str, data: bytes) -> None:
        """As `Storage.replace`."""
        atomic_files.replace(atomic_files.inside(self.place, name), data)

    def swap(self, name: str, data: bytes) -> None:
        """As `Storage.swap`: the lock of the folder sees to it that nobody else writes."""
        self.replace(name, data)

    def publish(self, name: str, data: bytes, durable: bool = True) -> bool:
        """As `Storage.publish`."""
        return atomic_files.publish(atomic_files.inside(self.place, name), data, durable)

    def sync(self, names: Iterable[str]) -> None:
        """As `Storage.sync`: once for each folder."""
        for folder in sorted({(self.place / name).parent for name in names}):
            with atomic_files.explained(folder):
                atomic_files.sync(folder)

    def listing(self, folders: Iterable[str], sweep: bool = True) -> Iterator[tuple[str, int]]:
        """As `Storage.listing`."""
        return atomic_files.listing(self.place, folders, sweep)

    def remove(self, name: str) -> None:
        """As `Storage.remove`."""
        with atomic_files.explained(self.place / name):
            atomic_files.inside(self.place, name).unlink(missing_ok=True)

    def set_aside(self, name: str) -> None:
        """As `Storage.set_aside`."""
        atomic_files.set_aside(self.place, name)

    def lock(self) -> None:
        """As `Storage.lock`."""
        self._lock = atomic_files.lock(self.place)

    def unlock(self) -> None:
        """As `Storage.unlock`."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def campaign(self, name: str, inputs: Iterable[str]) -> Path:
        """As `Storage.campaign`: files beside it are read in their turn."""
        del inputs
        return self.place / name

    def tidied(self) -> AbstractContextManager[None]:
        """As `Storage.tidied`."""
        return leaves_no_folder(self.place)
