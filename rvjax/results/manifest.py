"""The manifest: what a run is, and the SHA-256 of every file of data that belongs to it.

One JSON document that ends with the SHA-256 of the rest of itself, so that a change anywhere is noticed.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, cast

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError

from rvjax.errors import FolderError
from rvjax.results import files

FORMAT = 1
NAME = "manifest.json"

Digest = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]
ChunkFile = Annotated[str, StringConstraints(pattern=r"^samples/\d{5,}\.parquet$")]
OtherFile = Annotated[
    str,
    StringConstraints(pattern=r"^(campaign\.yaml|traces/sample-\d{7,}\.parquet|envelopes/\d{5,}\.parquet)$"),
]


class Chunk(BaseModel):
    """A finished chunk: `count` samples from number `first` on, in `file` with its SHA-256."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    chunk: Annotated[int, Field(ge=0)]
    file: ChunkFile
    first: Annotated[int, Field(ge=0)]
    count: Annotated[int, Field(ge=1)]
    sha256: Digest


class Manifest(BaseModel):
    """The run's name, identity, provenance and requested samples, its finished chunks, its other files' SHA-256."""

    model_config = ConfigDict(extra="forbid", strict=True)

    format: int = FORMAT
    name: str
    samples: Annotated[int, Field(ge=1)]
    identity: dict[str, Any]
    provenance: dict[str, Any]
    chunks: list[Chunk] = []
    files: dict[OtherFile, Digest] = {}

    def find(self, chunk: int) -> Chunk | None:
        """The entry of a finished chunk."""
        return next((entry for entry in self.chunks if entry.chunk == chunk), None)

    def encode(self) -> bytes:
        """The document, ending with the SHA-256 of everything before it; the same manifest gives the same bytes."""
        self.chunks.sort(key=lambda entry: entry.chunk)
        document = self.model_dump() | {"files": dict(sorted(self.files.items()))}
        return json_bytes(document | {"sha256": files.sha256(json_bytes(document))})

    @classmethod
    def read(cls, folder: Path) -> Manifest:
        """The manifest of a run folder.

        FolderError where there is none, where it was changed, or where another version of rvjax wrote it.
        """
        path = folder / NAME
        with files.explained(path):
            present = path.is_file()
        if not present:
            raise FolderError(f"{folder}: not a run folder, it has no {NAME}; accepted: one written by `rvjax run`")
        data = files.read(path)
        advice = "restore it from a copy, or fly the campaign again with another --out"
        try:
            document = json.loads(data)
            if document["format"] != FORMAT:
                found = document["format"]
                raise FolderError(f"{path}: format {found!r}, {FORMAT} is accepted; use the rvjax that wrote it")
            del document["sha256"]  # compared below, with everything else
            manifest = cls.model_validate(document)
        except (ValidationError, ValueError, KeyError, TypeError, RecursionError) as error:
            raise FolderError(f"{path}: damaged, not a manifest; {advice}") from error
        if manifest.encode() != data:
            raise FolderError(f"{path}: damaged or edited, it does not match the SHA-256 at its end; {advice}")
        return manifest


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


def differences(found: Mapping[str, Any], expected: Mapping[str, Any]) -> list[str]:
    """One line per part in which two identities differ: its dotted path and both values."""
    theirs, ours = _leaves(plain(found)), _leaves(plain(expected))
    return [
        f"{path}: the folder has {theirs.get(path, 'nothing')}, this run has {ours.get(path, 'nothing')}"
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
