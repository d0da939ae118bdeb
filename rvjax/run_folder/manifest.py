"""The manifest: the head of a run, and name, size and SHA-256 of each of its data files.

It is a JSON document that ends with the SHA-256 of all bytes before it, so that any change is noticed. It is written as a whole,
at the start and at the end of a run; files that are added between are in the journal (`rvjax.run_folder.journal`).
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

REBUILD = "run `rvjax doctor` on this folder to rebuild it from the data files"

_FILE = re.compile(r"(samples|envelopes|traces)/(?:sample-(?=\d{7}))?(\d{5,})-([0-9a-f]{16})\.parquet")


class Key(NamedTuple):
    """The contents of a data file: the samples or envelopes of a chunk, or the trace of a sample."""

    part: Part
    number: int

    def file(self, sha256: str) -> str:
        """The file's name in the run folder. It has the first 16 digits of the SHA-256, so a file can be verified by its name."""
        stem = f"sample-{self.number:07d}" if self.part == "traces" else f"{self.number:05d}"
        return f"{self.part}/{stem}-{sha256[:16]}.parquet"

    @classmethod
    def of(cls, file: str) -> Key | None:
        """The inverse of `file`; None if the name is not that of a data file."""
        match = _FILE.fullmatch(file)
        key = match and cls(cast("Part", match[1]), int(match[2]))
        return key if match and key and key.file(match[3]) == file else None


class Entry(BaseModel):
    """A data file in the manifest: `count` samples from number `first` on."""

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
            raise ValueError(f"{self.file} is not the name of a data file with this SHA-256")
        return self

    @property
    def key(self) -> Key:
        """The contents of the file."""
        return cast("Key", Key.of(self.file))

    @property
    def number(self) -> int:
        """The number of the chunk, or of the sample of a trace."""
        return self.key.number


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
    """The head of a run: name, samples, identity, provenance, audit, and the SHA-256 of the campaign file and its inputs."""

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
    """The head of a run and the entries of its data files by key."""

    def __init__(self, head: Head, entries: Iterable[Entry] = ()) -> None:
        self.head = head
        self.entries = {entry.key: entry for entry in entries}

    def encode(self) -> bytes:
        """The document as bytes; the same manifest gives the same bytes."""
        head = json.dumps(plain(self.head.model_dump()), indent=1).removesuffix("\n}")
        lines = ",\n  ".join(json.dumps(self.entries[key].model_dump()) for key in sorted(self.entries))
        body = f'{head},\n "files": [\n  {lines}\n ],\n'.encode()
        return body + _seal(body)

    @classmethod
    def decode(cls, path: Path, data: bytes) -> Self:
        """The inverse of `encode`. path: for messages. FolderError if the bytes were changed or have another format version."""
        body = data[: -len(_seal(b""))]
        try:
            document = json.loads(data)
            if document["format"] != FORMAT:
                version = document["format"]
                raise FolderError(f"{path}: format {version!r}; accepted: {FORMAT}; use the version of rvjax that wrote it")
            del document["sha256"]  # compared below with the whole document
            entries = ENTRIES.validate_python(document.pop("files"))
            manifest = cls(Head.model_validate(document), entries)
        except (ValidationError, ValueError, KeyError, TypeError, RecursionError) as error:
            raise FolderError(f"{path}: damaged, not a manifest; {REBUILD}") from error
        if body + _seal(body) != data:
            raise FolderError(f"{path}: damaged or edited, it does not match the SHA-256 at its end; {REBUILD}")
        if len(manifest.entries) != len(entries):
            raise FolderError(f"{path}: damaged, it names two files for the same chunk; {REBUILD}")
        return manifest


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


TOGETHER = 64
"""The largest number of chunks in a group of neighbours."""


def neighbours(chunks: Iterable[Entry], most: int = TOGETHER) -> Iterator[list[Entry]]:
    """Groups of up to `most` consecutive chunks without a gap between their samples."""
    group: list[Entry] = []
    for chunk in chunks:
        if group and (len(group) == most or chunk.first != group[-1].first + group[-1].count):
            yield group
            group = []
        group.append(chunk)
    if group:
        yield group
