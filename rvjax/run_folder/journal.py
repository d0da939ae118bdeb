"""The journal: what was committed since the manifest was written, one line for each file of data.

Its first line is the run's head and the SHA-256 of the manifest that it goes on from, its base; a journal with another base is
one whose lines that manifest has taken in. Every line begins with a check of the rest of it: `["<16 digits>", …]`. A line is on
the disk (fsync) before the next chunk is committed. A last line without its end is what a stopped process left; its file is
found again by its name.
"""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path
from typing import Any, Self

from pydantic import ValidationError

from rvjax.errors import FolderError
from rvjax.run_folder import atomic_files
from rvjax.run_folder.manifest import ENTRIES, REBUILD, Entry, Head, Manifest, plain
from rvjax.run_folder.manifest import NAME as MANIFEST

NAME = "journal.jsonl"

_CHECK = len('["0123456789abcdef", ')


class Journal:
    """The manifest and the journal of a run folder, as one: read, added to, folded together."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        self.root, self.manifest = root, manifest
        self._handle: int | None = None
        self._length = 0
        self._folded: tuple[Any, ...] | None = None
        self._seen: tuple[str, ...] = ()

    @classmethod
    def read(cls, root: Path) -> Self:
        """What is on the disk. FolderError where it is no run folder, or either file was changed or is missing."""
        path = root / MANIFEST
        if not atomic_files.exists(path):
            raise FolderError(f"{root}: not a run folder, it has no {MANIFEST}; accepted: one written by `rvjax run`")
        data = atomic_files.read(path)
        journal = cls(root, Manifest.decode(path, data))
        text = _text(root / NAME)
        base, _, entries = _decode(root / NAME, text)
        journal._seen = atomic_files.sha256(data), atomic_files.sha256(text)
        if base == journal._seen[0]:
            if text.find(b"\n") == len(text) - 1:  # no line, whole or not, behind the first
                journal._folded, journal._length = journal._state(), len(text)
            for entry in entries:
                journal.manifest.entries[entry.key] = entry
        return journal

    @property
    def current(self) -> bool:
        """Whether what was read is what is on the disk now."""
        return self._seen == tuple(atomic_files.sha256(_text(self.root / name)) for name in (MANIFEST, NAME))

    def add(self, entry: Entry) -> None:
        """Adds a file that is on the disk; so is its line when this returns. Only after `fold`."""
        line = _line(entry.model_dump())
        self._folded = None
        self.manifest.entries[entry.key] = entry  # before the line: one that is interrupted is in the manifest at the end
        with atomic_files.explained(self.root / NAME):
            assert self._handle is not None
            try:
                if os.write(self._handle, line) < len(line):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                os.fsync(self._handle)
            except OSError:
                del self.manifest.entries[entry.key]
                os.ftruncate(self._handle, self._length)  # no half line before the next one
                raise
        self._length += len(line)

    def fold(self) -> None:
        """Writes the manifest with all that there is, and an empty journal that goes on from it: in this order, so that nothing
        is lost in between; a new folder gets its manifest last, and is none before. Where both are so already, they stay."""
        state = self._state()
        if state != self._folded:
            self.close()
            self._folded = None
            data = self.manifest.encode()
            head = _line({"base": atomic_files.sha256(data), "head": state[0]})
            new = {MANIFEST: data, NAME: head}
            for name in new if (self.root / MANIFEST).exists() else reversed(new):
                atomic_files.replace(self.root / name, new[name])
            self._folded, self._length = state, len(head)
        if self._handle is None:
            with atomic_files.explained(self.root / NAME):
                self._handle = os.open(self.root / NAME, os.O_WRONLY | os.O_APPEND)

    def _state(self) -> tuple[Any, ...]:
        """Everything that the manifest is to hold."""
        return plain(self.manifest.head.model_dump()), dict(self.manifest.entries)

    def close(self) -> None:
        """Closes the file."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None


def head_of(root: Path) -> Head:
    """The head of the run, from whichever of the two files is whole; FolderError where neither is."""
    try:
        return Manifest.decode(root / MANIFEST, atomic_files.read(root / MANIFEST)).head
    except FolderError as error:
        try:
            return _decode(root / NAME, _text(root / NAME), 1)[1]
        except FolderError:
            raise FolderError(
                f"{root}: neither {MANIFEST} nor {NAME} is whole, so nothing says what was flown here; "
                "restore one of them from a copy, or fly the campaign again with another --out"
            ) from error


def _line(value: dict[str, Any]) -> bytes:
    return _checked(json.dumps(value, allow_nan=False).encode())


def _checked(text: bytes) -> bytes:
    return b'["' + atomic_files.sha256(text)[:16].encode() + b'", ' + text + b"]\n"


def _text(path: Path) -> bytes:
    """The whole file; nothing where there is none."""
    return atomic_files.read(path) if atomic_files.exists(path) else b""


def _decode(path: Path, text: bytes, at_most: int | None = None) -> tuple[str, Head, list[Entry]]:
    """Base, head and entries; FolderError where a line was changed or the first is missing. at_most: of so many lines."""
    lines = text.split(b"\n")[:-1][:at_most]
    try:
        for number, line in enumerate(lines, start=1):
            if _checked(line[_CHECK:-1]) != line + b"\n":
                raise FolderError(f"{path}: damaged or edited in line {number}; {REBUILD}")
        first, *others = (json.loads(line[_CHECK:-1]) for line in lines)
        return str(first["base"]), Head.model_validate(first["head"]), ENTRIES.validate_python(others)
    except (ValidationError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise FolderError(f"{path}: {'damaged, no journal' if text else 'missing or empty'}; {REBUILD}") from error
