"""Entry: name, size, SHA-256 and samples of a data file; its key says what the file contains."""

from __future__ import annotations

import re
from typing import Annotated, Literal, NamedTuple, Self, cast

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, TypeAdapter, model_validator

Part = Literal["samples", "envelopes", "traces"]
PARTS: tuple[Part, ...] = ("samples", "envelopes", "traces")
"""The folders of data files."""

Digest = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]

LARGEST = 10**15 - 1
"""The largest number of a chunk or sample, and of bytes in a file: it fits into the columns of `EntryRows`."""

_FILE = re.compile(
    r"(samples|envelopes)/([0-9]{5}|[1-9][0-9]{5,14})-([0-9a-f]{16})\.parquet"
    r"|(traces)/sample-([0-9]{7}|[1-9][0-9]{7,14})-([0-9a-f]{16})\.parquet"
)

_Size = Annotated[int, Field(ge=0, le=LARGEST)]


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
        named = parsed(file)
        return named and named[0]


def parsed(file: str) -> tuple[Key, str] | None:
    """The key of a data file and the digits of the SHA-256 in its name; None if the name is not that of a data file."""
    if (match := _FILE.fullmatch(file)) is None:
        return None
    part, number, digits = match.group(1, 2, 3) if match[1] else match.group(4, 5, 6)
    return Key(cast("Part", part), int(number)), digits


class Entry(BaseModel):
    """A data file in the manifest: `count` samples from number `first` on."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    file: str
    sha256: Digest
    bytes: _Size
    first: _Size
    count: Annotated[int, Field(ge=1, le=LARGEST)]

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


ENTRIES = TypeAdapter(list[Entry])
