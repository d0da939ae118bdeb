"""Storage: where the files of a run folder are kept. Local files and objects keep the same promises by other means.

A file is there completely or not at all, also after a stop at any instant. The names are relative to the run folder.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Protocol

from rvjax.campaign.source import Source
from rvjax.places import Place

MANIFEST = "manifest.json"
"""The file that makes a folder a run folder."""

LEASE = "writer.json"
"""The object that says which process writes into a run folder in an object store."""


class Log(Protocol):
    """The file to which the journal is appended. base: the SHA-256 of the manifest that it extends."""

    @property
    def name(self) -> str:
        """Its name in the run folder."""
        ...

    def read(self, base: str) -> bytes:
        """All of it; empty if there is none. If there is none of this base, that of another."""
        ...

    def start(self, base: str, first: bytes) -> None:
        """Begins a log with its first line, instead of the former."""
        ...

    def prepare(self) -> None:
        """Prepares for `append`, after `read` or `start`."""
        ...

    def append(self, lines: bytes) -> None:
        """Adds lines: durable on return, or none of them is there."""
        ...

    def seal(self) -> None:
        """Makes sure that nobody else has appended since it was read, before the manifest takes its lines."""
        ...

    def close(self) -> None:
        """Ends the appending."""
        ...

    def set_aside(self) -> None:
        """Moves it to `quarantine/`, if it is there."""
        ...


class Storage(Protocol):
    """The files of a run folder. Errors of the disk or of the store are messages for the user, as in `atomic_files`."""

    @property
    def place(self) -> Place:
        """The run folder."""
        ...

    @property
    def log(self) -> Log:
        """The file of the journal."""
        ...

    @property
    def most_lines(self) -> int:
        """The number of lines after which the journal is to be folded into the manifest."""
        ...

    def check(self) -> None:
        """UsageError where nothing can be written, before anything flies. Changes nothing."""
        ...

    def make(self) -> None:
        """Makes the place of a new run folder."""
        ...

    def names(self) -> list[str]:
        """The names of files and folders directly in the run folder, temporary files left out."""
        ...

    def below(self, folder: str) -> list[str]:
        """The names of all finished files in a folder and the folders below it, relative to it; empty if it is not there."""
        ...

    def exists(self, name: str) -> bool:
        """Whether there is such a file."""
        ...

    def read(self, name: str) -> bytes:
        """A whole file."""
        ...

    def replace(self, name: str, data: bytes) -> None:
        """Writes a file: a reader sees the old bytes or the new bytes."""
        ...

    def swap(self, name: str, data: bytes) -> None:
        """As `replace`, for a file that nobody else may have replaced since it was read here; UsageError otherwise."""
        ...

    def publish(self, name: str, data: bytes, durable: bool = True) -> bool:
        """Writes a file unless it exists: the first writer wins. Returns whether the file now holds `data`.

        durable: its name is durable on return; otherwise after `sync`.
        """
        ...

    def sync(self, names: Iterable[str]) -> None:
        """Makes the names of files durable."""
        ...

    def listing(self, folders: Iterable[str], sweep: bool = True) -> Iterator[tuple[str, int]]:
        """Name and size of every file directly in the folders. sweep: remove what a stopped process left unfinished."""
        ...

    def remove(self, name: str) -> None:
        """Removes a file if it is there."""
        ...

    def set_aside(self, name: str) -> None:
        """Moves a file to `quarantine/` under an unused name, if it is there."""
        ...

    def lock(self) -> None:
        """Reserves the folder for this process. UsageError if another process writes here."""
        ...

    def unlock(self) -> None:
        """Ends the reservation."""
        ...

    def campaign(self, name: str, inputs: Iterable[str]) -> Path | Source:
        """The campaign file for `rvjax.campaign.load`, with the files in `inputs/` that it names."""
        ...

    def tidied(self) -> AbstractContextManager[None]:
        """Removes a run folder that is made inside where an error ends the command before any data file is written."""
        ...


@contextmanager
def locked(storage: Storage) -> Generator[None, None, None]:
    """Reserves the folder; the reservation ends only if what is done inside fails."""
    storage.lock()
    try:
        yield
    except BaseException:
        storage.unlock()
        raise
