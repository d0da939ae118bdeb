"""An object store in memory, and one whose requests fail."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from rvjax.run_folder.atomic_files import sha256
from rvjax.run_folder.object_client import Conflict, Missing, Page, Unavailable

T = TypeVar("T")
PAGE = 3
"""Objects of a page, so that every listing has several."""


class MemoryClient:
    """The objects of a bucket, with the conditions of S3. honest: conditions are looked at."""

    def __init__(self, honest: bool = True) -> None:
        self.objects: dict[str, bytes] = {}
        self.honest = honest
        self._lock = threading.Lock()

    def get(self, key: str) -> tuple[bytes, str]:
        if key not in self.objects:
            raise Missing
        return self.objects[key], sha256(self.objects[key])

    def put(self, key: str, data: bytes, condition: str | None = None) -> str:
        with self._lock:
            held = self.objects.get(key)
            free = condition is None or (held is None if condition == "new" else held is not None and sha256(held) == condition)
            if self.honest and not free:
                raise Conflict
            self.objects[key] = data
        return sha256(data)

    def delete(self, key: str) -> None:
        self.objects.pop(key, None)

    def etag(self, key: str) -> str | None:
        return sha256(self.objects[key]) if key in self.objects else None

    def page(self, prefix: str, deep: bool, after: str = "") -> Page:
        names: dict[str, int] = {}
        for key in sorted(self.objects):
            if key.startswith(prefix):
                head, slash, _ = key.removeprefix(prefix).partition("/")
                name, size = (prefix + head + slash, 0) if slash and not deep else (key, len(self.objects[key]))
                names[name] = size
        rest = [(name, size) for name, size in names.items() if name > after]
        return Page(rest[:PAGE], rest[PAGE - 1][0] if len(rest) > PAGE else "")


class FailingClient:
    """One request in `every` fails: before it does its work, or after it, when the answer is lost.

    stop: the number of the request at which the process ends, before it or after it."""

    def __init__(self, client: MemoryClient, every: int = 0, seed: int = 0, stop: int = 0, after: bool = False) -> None:
        self._client, self._every = client, every
        self._random = np.random.default_rng(seed)
        self.requests = self.failures = 0
        self._stop, self._after = stop, after

    def _request(self, request: Callable[[], T]) -> T:
        from tests.disk import Killed

        self.requests += 1
        if self._stop and self.requests >= self._stop:
            if self._after and self.requests == self._stop:
                request()
            raise Killed
        fails = bool(self._every) and self._random.integers(self._every) == 0
        self.failures += int(fails)
        if fails and self._random.integers(2):
            raise Unavailable("503 Slow Down")
        answer = request()
        if fails:
            raise Unavailable("the connection was closed")
        return answer

    def get(self, key: str) -> tuple[bytes, str]:
        return self._request(lambda: self._client.get(key))

    def put(self, key: str, data: bytes, condition: str | None = None) -> str:
        return self._request(lambda: self._client.put(key, data, condition))

    def delete(self, key: str) -> None:
        self._request(lambda: self._client.delete(key))

    def etag(self, key: str) -> str | None:
        return self._request(lambda: self._client.etag(key))

    def page(self, prefix: str, deep: bool, after: str = "") -> Page:
        return self._request(lambda: self._client.page(prefix, deep, after))
