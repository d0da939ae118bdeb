"""The manifest: the head of a run, and name, size and SHA-256 of each of its data files, or of the file that lists them.

It is a JSON document that ends with the SHA-256 of all bytes before it, so that any change is noticed. It is written as a whole,
at the start and at the end of a run; files that are added between are in the journal (`rvjax.run_folder.journal`).
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, NamedTuple, Self, cast

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from rvjax.errors import FolderError
from rvjax.places import Place
from rvjax.run_folder import atomic_files
from rvjax.run_folder.entries import Entries, EntryRows
from rvjax.run_folder.entries_file import EntriesFile
from rvjax.run_folder.entry import ENTRIES, Digest, Entry
from rvjax.run_folder.storage import MANIFEST

FORMAT = 2
FORMAT_WITH_ENTRIES_FILE = 3
NAME = MANIFEST

REBUILD = "run `rvjax doctor` on this folder to rebuild it from the data files"


class Audited(BaseModel):
    """The result of the audit of the dispersions and of the fixed inputs before the first flight.

    dispersions: how many were audited. read_back: drawn columns whose values in the compiled program are those of the table.
    acting: dispersions that changed a flight when moved alone; moved: each of them with the number it changed most. idle:
    dispersions without an effect, which `audit.allow` permits, each with the number of flights that were tried. fixed: inputs
    without draws that were switched off. inert: fixed inputs without an effect, which `audit.allow` permits, each with the
    reason. warnings: on inputs that the steps cannot follow.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    dispersions: Annotated[int, Field(ge=0)]
    read_back: Annotated[int, Field(ge=0)]
    acting: Annotated[int, Field(ge=0)]
    idle: dict[str, int]
    moved: dict[str, str]
    fixed: Annotated[int, Field(ge=0)] = 0
    inert: dict[str, str] = {}
    warnings: list[str] = []

    @model_validator(mode="after")
    def _adds_up(self) -> Self:
        if self.acting != len(self.moved) or self.acting + len(self.idle) != self.dispersions or self.idle.keys() & self.moved:
            raise ValueError(f"{self.acting} acting and {len(self.idle)} idle dispersions are not {self.dispersions}")
        return self

    def __str__(self) -> str:
        if not self.dispersions:
            return f"Nothing is drawn: there was no dispersion to audit.{self._fixed}"
        audited = "1 dispersion was" if self.dispersions == 1 else f"{self.dispersions:,} dispersions were"
        read = "1 drawn column was" if self.read_back == 1 else f"{self.read_back:,} drawn columns were"
        idle = f"; without an effect, as audit.allow permits: {', '.join(self.idle)}" if self.idle else ""
        return (
            f"Before the first flight {audited} audited: {read} read back inside the compiled program, bit for bit or by an "
            f"independent formula, and {self.acting:,} acted when moved alone{idle}.{self._fixed}"
        )

    @property
    def _fixed(self) -> str:
        """Sentences on the fixed inputs, each with a space before it."""
        inputs = "1 fixed input was" if self.fixed == 1 else f"{self.fixed:,} fixed inputs were"
        off = f" {inputs} switched off to see the effect." if self.fixed else ""
        inert = "".join(f" Without an effect, as audit.allow permits: {name} ({why})." for name, why in self.inert.items())
        return f"{off}{inert}" + "".join(f" Warning: {warning}." for warning in self.warnings)


class Head(BaseModel):
    """The head of a run: name, samples, identity, provenance, audit, and the SHA-256 of the campaign file and its inputs.

    format: of a manifest that lists its entries itself; `Manifest.encode` writes another for one that names a file of them.
    """

    model_config = ConfigDict(extra="forbid", strict=True)

    format: int = FORMAT
    name: str
    samples: Annotated[int, Field(ge=1)]
    identity: dict[str, Any]
    provenance: dict[str, Any]
    audit: Audited | None = None
    campaign: Digest
    inputs: dict[str, Digest] = {}


class Manifest:
    """The head of a run and the entries of its data files by key."""

    def __init__(self, head: Head, entries: Iterable[Entry] | EntryRows = ()) -> None:
        self.head = head
        self.entries = Entries(entries)

    def encode(self, listed: EntriesFile | None = None) -> bytes:
        """The document as bytes; the same manifest gives the same bytes. listed: the file of the entries, which is named instead
        of them."""
        head = plain(self.head.model_dump())
        if listed:
            head["format"] = FORMAT_WITH_ENTRIES_FILE
            files = f' "entries": {json.dumps(listed.model_dump())},\n'
        else:
            lines = ",\n  ".join(json.dumps(entry.model_dump()) for entry in self.entries.rows)
            files = f' "files": [\n  {lines}\n ],\n'
        text = json.dumps(head, indent=1).removesuffix("\n}")
        body = f"{text},\n{files}".encode()
        return body + _seal(body)


class Document(NamedTuple):
    """A manifest file. entries: those that it lists, or the file that has them."""

    head: Head
    entries: list[Entry] | EntriesFile

    @classmethod
    def decode(cls, path: Place, data: bytes) -> Self:
        """The inverse of `Manifest.encode`. path: for messages. FolderError if the bytes were changed or have another format
        version."""
        body = data[: -len(_seal(b""))]
        try:
            document = json.loads(data)
            version = document["format"]
            if version not in (FORMAT, FORMAT_WITH_ENTRIES_FILE):
                accepted = f"{FORMAT} and {FORMAT_WITH_ENTRIES_FILE}"
                raise FolderError(f"{path}: format {version!r}; accepted: {accepted}; use the version of rvjax that wrote it")
            del document["sha256"]  # compared below with the whole document
            if version == FORMAT:
                entries = ENTRIES.validate_python(document.pop("files"))
            else:
                entries = EntriesFile.model_validate(document.pop("entries"))
            head = Head.model_validate(document | {"format": FORMAT})
        except (ValidationError, ValueError, KeyError, TypeError, RecursionError) as error:
            raise FolderError(f"{path}: damaged, not a manifest; {REBUILD}") from error
        if body + _seal(body) != data:
            raise FolderError(f"{path}: damaged or edited, it does not match the SHA-256 at its end; {REBUILD}")
        if isinstance(entries, list) and len({entry.key for entry in entries}) != len(entries):
            raise FolderError(f"{path}: damaged, it names two files for the same chunk; {REBUILD}")
        return cls(head, entries)


def _seal(body: bytes) -> bytes:
    return f' "sha256": "{atomic_files.sha256(body)}"\n}}\n'.encode()


def digest(identity: Mapping[str, Any]) -> str:
    """The SHA-256 of an identity; every data file contains it."""
    return atomic_files.sha256(json_bytes(identity))


def json_bytes(document: Mapping[str, Any]) -> bytes:
    """Strict JSON, indented, ASCII; numbers that are not finite become null."""
    return (json.dumps(plain(document), indent=1, allow_nan=False) + "\n").encode()


def plain(value: Any) -> Any:
    """The value as plain JSON: tuples and arrays as lists, NumPy numbers as Python numbers, not finite numbers as None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in cast("Mapping[Any, Any]", value).items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in cast("list[Any]", value)]
    if isinstance(value, np.ndarray | np.generic):
        return plain(cast("Any", value.tolist()))
    return None if isinstance(value, float) and not math.isfinite(value) else value


def differences(
    first: Mapping[str, Any], second: Mapping[str, Any], first_name: str = "the folder", second_name: str = "this run"
) -> list[str]:
    """A line for each value in which two identities differ: its dotted path and both values."""
    a, b = _leaves(plain(first)), _leaves(plain(second))
    return [
        f"{path}: {first_name} has {a.get(path, 'nothing')}, {second_name} has {b.get(path, 'nothing')}"
        for path in sorted(a.keys() | b.keys())
        if a.get(path) != b.get(path)
    ]


def _leaves(value: Any, path: str = "") -> dict[str, str]:
    """Every scalar of a nested document as JSON text, by dotted path."""
    if not value or not isinstance(value, dict | list):
        return {path: json.dumps(value, ensure_ascii=False)}
    items = cast("dict[str, Any]", value).items() if isinstance(value, dict) else enumerate(cast("list[Any]", value))
    leaves: dict[str, str] = {}
    for key, item in items:
        leaves |= _leaves(item, f"{path}.{key}" if path else str(key))
    return leaves
