"""The journal: the data files that were committed since the manifest was written, a line for each.

Its first line has the head of the run and the base: the SHA-256 of the manifest that the journal extends. If the base is another
SHA-256, the manifest contains all lines of the journal already. Every line begins with a checksum of its rest:
`["<16 digits>", …]`. The lines of a commit are on the disk (fsync) before the next commit. A stopped process may leave a last
line without its end; its data file is recognised by its name.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import partial
from typing import Any, Self

import pyarrow as pa
from pydantic import ValidationError

from rvjax.errors import FolderError
from rvjax.places import Place
from rvjax.run_folder import atomic_files
from rvjax.run_folder.entries_file import EntriesFile, decode, encode, is_entries_file
from rvjax.run_folder.entry import ENTRIES, Entry
from rvjax.run_folder.manifest import NAME as MANIFEST
from rvjax.run_folder.manifest import REBUILD, Document, Head, Manifest, plain
from rvjax.run_folder.storage import Storage

_CHECK = len('["0123456789abcdef", ')


LISTED = 4_096
"""The largest number of entries that the manifest lists itself; more are in a file that it names."""


class Journal:
    """Keeps a manifest on the disk: appends lines to the journal file, and folds them into the manifest file."""

    def __init__(self, storage: Storage) -> None:
        self.storage = storage
        self._open = False
        self._lines = 0
        self._folded: tuple[Any, ...] | None = None
        self._digests: tuple[str, ...] = ()
        self._listed: EntriesFile | None = None
        self._listed_revision = 0

    @classmethod
    def read(cls, storage: Storage) -> tuple[Self, Manifest]:
        """The journal and the manifest with the journal's files.

        FolderError if the path is not a run folder, or if one of its files was changed or is missing.
        """
        root = storage.place
        path = root / MANIFEST
        if not storage.exists(MANIFEST):
            raise FolderError(f"{root}: not a run folder, it has no {MANIFEST}; accepted: one written by `rvjax run`")
        data = storage.read(MANIFEST)
        journal, document = cls(storage), Document.decode(path, data)
        digest = atomic_files.sha256(data)
        try:
            manifest = journal._manifest(document)
            text = storage.log.read(digest)
            base, _, entries = _decode(root / storage.log.name, text)
        except FolderError:
            if _text(storage, MANIFEST) == data:
                raise
            return cls.read(storage)  # a writer has replaced the manifest, and removed what belonged to the former
        journal._digests = digest, atomic_files.sha256(text)
        if base == journal._digests[0]:
            if not entries and text.endswith(b"\n"):  # nothing after the first line
                journal._folded = _state(manifest)
            manifest.entries.update({entry.key: entry for entry in entries})
        return journal, manifest

    @property
    def current(self) -> bool:
        """Whether both files are still the same as when they were read."""
        digest = atomic_files.sha256(_text(self.storage, MANIFEST))
        return self._digests == (digest, atomic_files.sha256(self.storage.log.read(digest)))

    @property
    def due(self) -> bool:
        """Whether `fold` is needed before the next `append`: it did not succeed, or there are many lines."""
        return not self._open or self._lines >= self.storage.most_lines

    def append(self, entries: Iterable[Entry]) -> None:
        """Appends a line for each data file; all lines are on the disk on return, or none is. Only after `fold`."""
        lines = [_line(entry.model_dump()) for entry in entries]
        self._folded = None
        self.storage.log.append(b"".join(lines))
        self._lines += len(lines)

    def fold(self, manifest: Manifest) -> None:
        """Writes the manifest, then an empty journal that extends it, so that nothing is lost between the two.

        The file of many entries is written before the manifest that names it, and an older one is removed at the end. In a new
        folder the manifest comes last: it makes the folder a run folder. If all files are up to date, they stay.
        """
        state, storage = _state(manifest), self.storage
        if state != self._folded:
            self.close()
            self._folded = None
            storage.log.seal()
            self._write_entries(manifest)
            data = manifest.encode(self._listed)
            base = atomic_files.sha256(data)
            head = _line({"base": base, "head": state[0]})
            steps = (partial(storage.swap, MANIFEST, data), partial(storage.log.start, base, head))
            for step in steps if storage.exists(MANIFEST) else reversed(steps):
                step()
            self._folded, self._lines = state, 0
        if not self._open:
            self._sweep()
            storage.log.prepare()
            self._open = True

    def _manifest(self, document: Document) -> Manifest:
        """The manifest of a document, with the entries from their file."""
        head, entries = document
        if not isinstance(entries, EntriesFile):
            return Manifest(head, entries)
        path = self.storage.place / entries.name
        if not self.storage.exists(entries.name):
            raise FolderError(f"{path}: missing, but {MANIFEST} names it; {REBUILD}")
        data = self.storage.read(entries.name)
        try:
            if atomic_files.sha256(data) != entries.sha256:
                raise ValueError("another SHA-256 than in the manifest")
            rows = decode(data, entries.count)
        except (pa.ArrowException, OSError, ValueError) as error:
            raise FolderError(f"{path}: damaged or edited ({error}); {REBUILD}") from error
        manifest = Manifest(head, rows)
        self._listed, self._listed_revision = entries, manifest.entries.revision
        return manifest

    def _write_entries(self, manifest: Manifest) -> None:
        """Writes the file of many entries, unless it has them already."""
        entries = manifest.entries
        if len(entries) <= LISTED:
            self._listed = None
        elif self._listed is None or self._listed_revision != entries.revision:
            listed, data = encode(entries.rows)
            self.storage.replace(listed.name, data)
            self._listed, self._listed_revision = listed, entries.revision

    def _sweep(self) -> None:
        """Removes the entries files that the manifest does not name."""
        for name in entries_files(self.storage):
            if self._listed is None or name != self._listed.name:
                self.storage.remove(name)

    def close(self) -> None:
        """Ends the appending."""
        self.storage.log.close()
        self._open = False


def head_of(storage: Storage) -> Head:
    """The head of the run from the manifest, or from the journal if the manifest is damaged. FolderError if both are damaged."""
    root = storage.place
    try:
        return Document.decode(root / MANIFEST, _text(storage, MANIFEST)).head
    except FolderError as error:
        try:
            return _decode(root / storage.log.name, storage.log.read(""), 1)[1]
        except FolderError:
            raise FolderError(
                f"{root}: neither {MANIFEST} nor {storage.log.name} is whole, so rvjax does not know what was flown here; "
                "restore one of them from a copy, or fly the campaign again with another --out"
            ) from error


def entries_files(storage: Storage) -> list[str]:
    """The names of all entries files in a run folder."""
    return [name for name, _ in storage.listing([""], sweep=False) if is_entries_file(name)]


def _state(manifest: Manifest) -> tuple[Any, ...]:
    """A copy of the head, and the revision of the entries, to notice changes."""
    return plain(manifest.head.model_dump()), manifest.entries.revision


def _line(value: dict[str, Any]) -> bytes:
    return _checked(json.dumps(value, allow_nan=False).encode())


def _checked(text: bytes) -> bytes:
    return b'["' + atomic_files.sha256(text)[:16].encode() + b'", ' + text + b"]\n"


def _text(storage: Storage, name: str) -> bytes:
    """The bytes of a file; empty if there is no file."""
    return storage.read(name) if storage.exists(name) else b""


def _decode(path: Place, text: bytes, at_most: int | None = None) -> tuple[str, Head, list[Entry]]:
    """Base, head and entries of the first `at_most` lines. FolderError if a line was changed or the first is missing."""
    lines = text.split(b"\n")[:-1][:at_most]
    try:
        for number, line in enumerate(lines, start=1):
            if _checked(line[_CHECK:-1]) != line + b"\n":
                raise FolderError(f"{path}: damaged or edited in line {number}; {REBUILD}")
        first, *others = (json.loads(line[_CHECK:-1]) for line in lines)
        return str(first["base"]), Head.model_validate(first["head"]), ENTRIES.validate_python(others)
    except (ValidationError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise FolderError(f"{path}: {'damaged, not a journal' if text else 'missing or empty'}; {REBUILD}") from error
