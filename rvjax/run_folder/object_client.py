"""ObjectClient: what a run folder needs from an object store, and how failing requests are repeated.

The store must refuse to create an object that exists (If-None-Match) and to replace an object that has changed (If-Match).
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from typing import Literal, NamedTuple, Protocol, TypeVar

T = TypeVar("T")

ATTEMPTS = 8
FIRST_WAIT_S = 0.1
LONGEST_WAIT_S = 10.0


class Missing(Exception):
    """There is no such object."""


class Conflict(Exception):
    """The object exists already, or is not the one that was to be replaced."""


class Unavailable(Exception):
    """The request failed, or its answer was lost: it may have succeeded. A later attempt may succeed."""


class Refused(Exception):
    """The store refuses the request, now and later: no such bucket, no credentials, no permission."""


class Page(NamedTuple):
    """Keys and sizes of objects. after: for the request of the next page; empty for the last page."""

    entries: list[tuple[str, int]]
    after: str


class ObjectClient(Protocol):
    """Requests to a bucket. Errors: those above. etag: names the version of an object."""

    def get(self, key: str) -> tuple[bytes, str]:
        """The bytes of an object and its etag."""
        ...

    def put(self, key: str, data: bytes, condition: Literal["new"] | str | None = None) -> str:
        """Writes an object and returns its etag. condition: `new`: unless it exists; an etag: only over this version."""
        ...

    def delete(self, key: str) -> None:
        """Removes an object, which may be missing."""
        ...

    def etag(self, key: str) -> str | None:
        """The etag of an object; None if there is none."""
        ...

    def page(self, prefix: str, deep: bool, after: str = "") -> Page:
        """A page of the objects whose keys begin with a prefix. deep: also behind further slashes; else a key that ends with a
        slash stands for those. after: as the page before says."""
        ...


def repeated(request: Callable[[], T], wait: Callable[[float], None] = time.sleep) -> T:
    """The answer of a request, which is repeated with growing pauses while the store is `Unavailable`."""
    for attempt in range(ATTEMPTS - 1):
        try:
            return request()
        except Unavailable:
            pause = min(FIRST_WAIT_S * 2.0**attempt, LONGEST_WAIT_S)
            wait(pause * random.uniform(0.5, 1.0))
    return request()
