"""Places of run folders: a path of this machine, or a prefix in an object store as `s3://bucket/prefix`."""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath

_URL = re.compile(r"([a-z][a-z0-9+.-]+):/")


class ObjectPath(PurePosixPath):
    """A name in an object store, such as `s3://bucket/prefix/name`; it joins, compares and prints as a path does."""

    def __str__(self) -> str:
        return _URL.sub(r"\1://", super().__str__(), count=1)

    @property
    def protocol(self) -> str:
        """The kind of store, such as `s3`."""
        return self.parts[0].rstrip(":")

    @property
    def bucket(self) -> str:
        """The bucket; empty if there is none."""
        return self.parts[1] if len(self.parts) > 1 else ""

    @property
    def key(self) -> str:
        """The name inside the bucket; empty for the bucket itself."""
        return "/".join(self.parts[2:])


Place = Path | ObjectPath


def place_of(place: str | Path | ObjectPath) -> Place:
    """The place that a user names. `Path("s3://bucket/x")` is `s3:/bucket/x`, so a single slash behind the colon is accepted."""
    if isinstance(place, ObjectPath):
        return place
    text = str(place)
    return ObjectPath(text) if _URL.match(text) else Path(text)
