"""The manifest: what a run is, and name, size and SHA-256 of every file of data that belongs to it.

One JSON document whose last entry is the SHA-256 of all that stands before it, so that a change anywhere is noticed. It is
written as a whole, at the start and at the end of a run; what comes between them is in the journal (`rvjax.run_folder.journal`).
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self, cast

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, StringConstraints, TypeAdapter, ValidationError, model_validator

from rvjax.errors import FolderError
from rvjax.run_folder import atomic_files

FORMAT = 2
NAME = "manifest.json"

Part = Literal["samples", "envelopes", "traces"]
Digest = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]

REBUILD = "`rvjax doctor` with this folder makes it again from the files"

_FILE = re.compile(r"(samples|envelopes|traces)/(?:sample-(?=\d{7}))?(\d{5,})-([0-9a-f]{16})\.parquet")


class Key(NamedTuple):
    """A file of data by what it is of: a chunk's samples or envelopes, or a sample's trace."""

    part: Part
    number: int

    def file(self, sha256: str) -> str:
        """Its name in the run folder, with the first 16 digits of its SHA-256: a file shows by itself whether it is whole."""
        stem = f"sample-{self.number:07d}" if self.part == "traces" else f"{self.number:05d}"
        return f"{self.part}/{stem}-{sha256[:16]}.parquet"

    @classmethod
    def of(cls, file: str) -> Key | None:
        """The inverse of `file`; None where it is no such name."""
        match = _FILE.fullmatch(file)
        key = match and cls(cast("Part", match[1]), int(match[2]))
        return key if match and key and key.file(match[3]) == file else None


class Entry(BaseModel):
    """A file of data: `count` samples from number `first` on."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    file: str
    sha256: Digest
    bytes: Annotated[int, Field(ge=0)]
    first: Annotated[int, Field(ge=0)]
    count: Annotated[int, Field(ge=1)]

    @model_validator(mode="after")
    def _named(self) -> Self:
        key = Key.of(self.file)
        if key is None or key.file(self.sha256) != self.file:
            raise ValueError(f"{self.file} is no name of a file of data with this SHA-256")
        return self

    @property
    def key(self) -> Key:
        """What the file is of."""
        return cast("Key", Key.of(self.file))

    @property
    def number(self) -> int:
        """The chunk, or the sample of a trace."""
        return self.key.number


class Audited(BaseModel):
    """What was proved of the dispersions before the first flight.

    dispersions: how many were audited. read_back: drawn columns that were found in the compiled program as the table has them.
    acting: dispersions that changed a flight when they alone were moved; moved: each with the number that it changed most.
    idle: those without an effect, which `audit.allow` lets pass, each with the number of flights that it was tried on.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    dispersions: Annotated[int, Field(ge=0)]
    read_back: Annotated[int, Field(ge=0)]
    acting: Annotated[int, Field(ge=0)]
    idle: dict[str, int]
    moved: dict[str, str]

    @model_validator(mode="after")
    def _adds_up(self) -> Self:
        if self.acting != len(self.moved) or self.acting + len(self.idle) != self.dispersions or self.idle.keys() & self.moved:
            raise ValueError(f"{self.acting} acting and {len(self.idle)} idle dispersions are not {self.dispersions}")
        return self

    def __str__(self) -> str:
        if not self.dispersions:
            return "Nothing is drawn: there was no dispersion to audit."
        audited = "1 dispersion was" if self.dispersions == 1 else f"{self.dispersions:,} dispersions were"
        read = "1 drawn column was" if self.read_back == 1 else f"{self.read_back:,} drawn columns were"
        idle = f"; without an effect, as audit.allow lets them: {', '.join(self.idle)}" if self.idle else ""
        return (
            f"Before the first flight {audited} audited: {read} read back inside the compiled program, bit for bit or by an "
            f"independent formula, and {self.acting:,} acted when moved alone{idle}."
        )


class Head(BaseModel):
    """The run's name, requested samples, identity, provenance and audit, and the SHA-256 of its campaign file and of those it
    names."""

    model_config = ConfigDict(extra="forbid", strict=True)

    format: int = FORMAT
    name: str
    samples: Annotated[int, Field(ge=1)]
    identity: dict[str, Any]
    provenance: dict[str, Any]
    audit: Audited | None = None
    campaign: Digest
    inputs: dict[str, Digest] = {}


ENTRIES = TypeAdapter(list[Entry])


class Manifest:
    """A run's head, and its files of data by their keys."""

    def __init__(self, head: Head, entries: Iterable[Entry] = ()) -> None:
        self.head = head
        self.entries = {entry.key: entry for entry in entries}

    def encode(self) -> bytes:
        """The document; the same manifest gives the same bytes."""
        head = json.dumps(plain(self.head.model_dump()), indent=1).removesuffix("\n}")
        lines = ",\n  ".join(json.dumps(self.entries[key].model_dump()) for key in sorted(self.entries))
        body = f'{head},\n "files": [\n  {lines}\n ],\n'.encode()
        return body + _seal(body)

    @classmethod
    def decode(cls, path: Path, data: bytes) -> Self:
        """The inverse of `encode`. FolderError where the bytes, those of `path`, were changed or are of another version."""
        body = data[: -len(_seal(b""))]
        try:
            document = json.loads(data)
            if document["format"] != FORMAT:
                found = document["format"]
                raise FolderError(f"{path}: format {found!r}, {FORMAT} is accepted; use the rvjax that wrote it")
            del document["sha256"]  # compared below, with everything else
            entries = ENTRIES.validate_python(document.pop("files"))
            manifest = cls(Head.model_validate(document), entries)
        except (ValidationError, ValueError, KeyError, TypeError, RecursionError) as error:
            raise FolderError(f"{path}: damaged, not a manifest; {REBUILD}") from error
        if body + _seal(body) != data:
            raise FolderError(f"{path}: damaged or edited, it does not match the SHA-256 at its end; {REBUILD}")
        if len(manifest.entries) != len(entries):
            raise FolderError(f"{path}: damaged, it names two files of one chunk; {REBUILD}")
        return manifest


def _seal(body: bytes) -> bytes:
    return f' "sha256": "{atomic_files.sha256(body)}"\n}}\n'.encode()


def digest(identity: Mapping[str, Any]) -> str:
    """The SHA-256 of an identity; every file of data carries it."""
    return atomic_files.sha256(json_bytes(identity))


def json_bytes(document: Mapping[str, Any]) -> bytes:
    """Strict JSON, indented, ASCII; numbers that are not finite become null."""
    return (json.dumps(plain(document), indent=1, allow_nan=False) + "\n").encode()


def plain(value: Any) -> Any:
    """The value as JSON has it: tuples and arrays as lists, NumPy's numbers as Python's, those not finite as None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in cast("Mapping[Any, Any]", value).items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in cast("list[Any]", value)]
    if isinstance(value, np.ndarray | np.generic):
        return plain(cast("Any", value.tolist()))
    return None if isinstance(value, float) and not math.isfinite(value) else value


def differences(
    found: Mapping[str, Any], expected: Mapping[str, Any], theirs_is: str = "the folder", ours_is: str = "this run"
) -> list[str]:
    """One line per part in which two identities differ: its dotted path and both values, each with whose it is."""
    theirs, ours = _leaves(plain(found)), _leaves(plain(expected))
    return [
        f"{path}: {theirs_is} has {theirs.get(path, 'nothing')}, {ours_is} has {ours.get(path, 'nothing')}"
        for path in sorted(ours.keys() | theirs.keys())
        if ours.get(path) != theirs.get(path)
    ]


def _leaves(value: Any, path: str = "") -> dict[str, str]:
    """Every scalar of a nested document as JSON text, by its dotted path."""
    if not value or not isinstance(value, dict | list):
        return {path: json.dumps(value, ensure_ascii=False)}
    items = cast("dict[str, Any]", value).items() if isinstance(value, dict) else enumerate(cast("list[Any]", value))
    leaves: dict[str, str] = {}
    for key, item in items:
        leaves |= _leaves(item, f"{path}.{key}" if path else str(key))
    return leaves


TOGETHER = 64
"""Chunks in a group of neighbours, at most."""


def neighbours(chunks: Iterable[Entry], most: int = TOGETHER) -> Iterator[list[Entry]]:
    """Chunks in groups whose samples lie without a gap."""
    group: list[Entry] = []
    for chunk in chunks:
        if group and (len(group) == most or chunk.first != group[-1].first + group[-1].count):
            yield group
            group = []
        group.append(chunk)
    if group:
        yield group
