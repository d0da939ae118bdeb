"""ObjectStorage: a run folder in an object store, which has no rename, no links and no locks.

An object is there completely or not at all. A data file is created only if its name is free; it has 16 digits of its SHA-256 in
its name. The manifest is replaced only over the version that was read (compare and swap). The journal is a series of numbered
objects, `journal/<16 digits of the manifest's SHA-256>-<number>`, each created only if its number is free: of two writers, one is
refused at its next commit. `writer.json` names the process that writes, so that a second one is refused at its start.

An answer may be lost after the request has succeeded. Then the object "exists" at the next attempt, and its bytes decide.
"""

from __future__ import annotations

import json
import os
import re
import socket
import time
import uuid
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Any, TypeVar

from rvjax.campaign.source import Source, read_text
from rvjax.errors import DamagedError, FolderError, IncompleteError, UsageError
from rvjax.places import ObjectPath
from rvjax.run_folder import atomic_files
from rvjax.run_folder.atomic_files import plain_parts
from rvjax.run_folder.entry import PARTS
from rvjax.run_folder.object_client import Conflict, Missing, ObjectClient, Refused, Unavailable, repeated
from rvjax.run_folder.storage import LEASE, MANIFEST

T = TypeVar("T")

LEASE_S = 900.0
"""How long a process counts as writing after its last sign of life."""

MOST_LINES = 1_024
"""As `Storage.most_lines`: each commit is an object, which is read by itself."""

TOGETHER = 16
"""Objects of a journal that are read at the same time."""

_SEGMENT = re.compile(r"journal/([0-9a-f]{16})-([0-9]{8})")
_ANOTHER = "another process is writing here; wait for its end, or choose another folder with --out"


class ObjectStorage:
    """The objects below a prefix."""

    def __init__(self, place: ObjectPath, client: ObjectClient) -> None:
        self.place, self._client = place, client
        self._prefix = f"{place.key}/" if place.key else ""
        self.token = uuid.uuid4().hex
        self.log = ObjectLog(self)
        self._etags: dict[str, str] = {}
        self._renewed = 0.0

    @property
    def most_lines(self) -> int:
        """As `Storage.most_lines`."""
        return MOST_LINES

    def request(self, name: str, request: Callable[[ObjectClient, str], T]) -> T:
        """The answer to a request about an object, repeated while the store does not answer. Errors are messages for the user,
        but for `Missing` and `Conflict`."""
        key = self._prefix + name
        try:
            return repeated(lambda: request(self._client, key))
        except Unavailable as error:
            advice = "give the same command again: committed results are kept"
            raise IncompleteError(f"{self.place / name}: {error}; the store does not answer: {advice}") from error
        except Refused as error:
            raise FolderError(f"{self.place / name}: {error}") from error

    def check(self) -> None:
        """As `Storage.check`: reads a page of names."""
        try:
            next(self._listing("", deep=False), None)
        except FolderError as error:
            raise UsageError(f"{self.place}: cannot be written: {error.__cause__}") from error

    def make(self) -> None:
        """As `Storage.make`: there is nothing to make."""

    def names(self) -> list[str]:
        """As `Storage.names`."""
        return [name.rstrip("/") for name, _ in self._listing("", deep=False)]

    def below(self, folder: str) -> list[str]:
        """As `Storage.below`."""
        prefix = f"{folder}/" if folder else ""
        return [name.removeprefix(prefix) for name, _ in self._listing(prefix, deep=True)]

    def exists(self, name: str) -> bool:
        """As `Storage.exists`."""
        return self.request(name, lambda client, key: client.etag(key)) is not None

    def read(self, name: str) -> bytes:
        """As `Storage.read`."""
        plain_parts(self.place, name)
        try:
            data, self._etags[name] = self.request(name, lambda client, key: client.get(key))
        except Missing:
            raise FolderError(f"{self.place / name}: no such object; give the path of a run folder") from None
        return data

    def replace(self, name: str, data: bytes) -> None:
        """As `Storage.replace`."""
        plain_parts(self.place, name)
        self._etags[name] = self.request(name, lambda client, key: client.put(key, data))

    def swap(self, name: str, data: bytes) -> None:
        """As `Storage.swap`."""
        condition = self._etags.get(name, "new")
        try:
            self._etags[name] = self.request(name, lambda client, key: client.put(key, data, condition))
        except (Conflict, Missing):
            if not self.exists(name) or self.read(name) != data:  # else an earlier attempt succeeded, and its answer was lost
                self._etags.pop(name, None)
                raise UsageError(f"{self.place}: {_ANOTHER}") from None

    def unchanged(self, name: str) -> bool:
        """Whether a file is still the version that was read or written here."""
        return self.request(name, lambda client, key: client.etag(key)) == self._etags.get(name)

    def publish(self, name: str, data: bytes, durable: bool = True) -> bool:
        """As `Storage.publish`."""
        del durable
        plain_parts(self.place, name)
        try:
            self.request(name, lambda client, key: client.put(key, data, "new"))
        except Conflict:
            return self.read(name) == data
        return True

    def sync(self, names: Iterable[str]) -> None:
        """As `Storage.sync`: an object that the store has accepted is durable."""

    def listing(self, folders: Iterable[str], sweep: bool = True) -> Iterator[tuple[str, int]]:
        """As `Storage.listing`: nothing is unfinished."""
        del sweep
        for folder in folders:
            names = self._listing(f"{folder}/" if folder else "", deep=False)
            yield from ((name, size) for name, size in names if not name.endswith("/"))

    def remove(self, name: str) -> None:
        """As `Storage.remove`."""
        plain_parts(self.place, name)
        self.request(name, lambda client, key: client.delete(key))
        self._etags.pop(name, None)

    def set_aside(self, name: str) -> None:
        """As `Storage.set_aside`: a copy, then the removal."""
        if not self.exists(name):
            return
        data, number = self.read(name), len(self.below(atomic_files.QUARANTINE))
        while not self.publish(f"{atomic_files.QUARANTINE}/{name.replace('/', '-')}.{number}", data):
            number += 1
        self.remove(name)

    def lock(self) -> None:
        """As `Storage.lock`: writes the lease. UsageError also if the store ignores the conditions of requests."""
        data = self._lease()
        if not self.publish(LEASE, data):
            holder = self._holder()
            if holder is not None and holder["until"] > time.time() and not _ended(holder):
                advice = f"wait for its end; if it has ended, remove {self.place / LEASE}; or choose another folder with --out"
                who = f"process {holder['pid']} on {holder['host']}"
                raise UsageError(f"{self.place}: another process is writing here ({who}); {advice}")
            self.swap(LEASE, data)
        self.read(LEASE)
        self._renewed = time.monotonic()
        for condition in ("new", '"00000000000000000000000000000000"'):
            with suppress(Conflict, Missing):
                self.request(LEASE, lambda client, key, condition=condition: client.put(key, data, condition))
                self.remove(LEASE)
                raise UsageError(
                    f"{self.place}: the store ignores the conditions If-None-Match and If-Match, so two processes could destroy "
                    "each other's results; accepted: a store with conditional writes, such as Amazon S3, or a folder"
                )

    def renew(self) -> None:
        """Says that this process still writes; UsageError if another one has taken over."""
        if time.monotonic() - self._renewed > LEASE_S / 4:
            self.swap(LEASE, self._lease())
            self._renewed = time.monotonic()

    def unlock(self) -> None:
        """As `Storage.unlock`."""
        with suppress(IncompleteError, FolderError):  # a lease that stays ends by itself
            holder = self._holder() if self._renewed else None
            if holder is not None and holder["token"] == self.token:
                self.remove(LEASE)
        self._renewed = 0.0

    def campaign(self, name: str, inputs: Iterable[str]) -> Source:
        """As `Storage.campaign`."""
        files = {file: self.read(f"inputs/{file}") for file in inputs}
        return replace(read_text(self.read(name).decode(), str(self.place / name)), inputs=files)

    @contextmanager
    def tidied(self) -> Generator[None, None, None]:
        """As `Storage.tidied`."""
        empty = not self.names()
        try:
            yield
        except IncompleteError:
            raise
        except Exception:
            if empty and not any(True for _ in self.listing(PARTS)):
                for name in self.below(""):
                    self.remove(name)
            raise

    def _listing(self, folder: str, deep: bool) -> Iterator[tuple[str, int]]:
        """Name and size of the objects below a folder, which is empty or ends with a slash, a page at a time."""
        after, first = "", True
        while first or after:
            page = self.request(folder, lambda client, key, after=after: client.page(key, deep, after))
            yield from ((name.removeprefix(self._prefix), size) for name, size in page.entries)
            after, first = page.after, False

    def _lease(self) -> bytes:
        holder = {"token": self.token, "host": socket.gethostname(), "pid": os.getpid(), "until": time.time() + LEASE_S}
        return json.dumps(holder).encode()

    def _holder(self) -> dict[str, Any] | None:
        """What the lease says; None if there is none, or if it is damaged."""
        with suppress(FolderError, ValueError, TypeError, KeyError):
            holder = json.loads(self.read(LEASE))
            return {name: kind(holder[name]) for name, kind in (("token", str), ("host", str), ("pid", int), ("until", float))}
        return None


class ObjectLog:
    """The journal as numbered objects. The first line of each is the token of its writer, so that no two writers' are equal."""

    name = "journal"

    def __init__(self, storage: ObjectStorage) -> None:
        self._storage = storage
        self._series, self._next = "", 0

    def read(self, base: str) -> bytes:
        """As `Log.read`."""
        names = sorted(name for name in self._storage.below("journal"))
        series: dict[str, list[int]] = {}
        for name in names:
            if match := _SEGMENT.fullmatch(f"journal/{name}"):
                series.setdefault(match[1], []).append(int(match[2]))
        if base[:16] in series:
            self._series, self._next = base[:16], len(series[base[:16]])
        key = base[:16] if base[:16] in series else next(iter(series), "")
        numbers = series.get(key, [])
        if numbers != list(range(len(numbers))):
            raise DamagedError(f"{self._storage.place}: objects of journal/{key} are missing; run `rvjax doctor` on this folder")
        with ThreadPoolExecutor(TOGETHER) as threads:
            texts = list(threads.map(lambda number: self._storage.read(_name(key, number)), numbers))
        return b"".join(text.partition(b"\n")[2] for text in texts)

    def start(self, base: str, first: bytes) -> None:
        """As `Log.start`. The former series is removed when the new one has its first object."""
        self._series, self._next = base[:16], 0
        try:
            self._add(first)
        except UsageError:
            if self.read(base) != first or self._next != 1:
                raise
            self._add(b"")  # begun by a process that was stopped before it went on: from now on it is refused
        for name in self._storage.below("journal"):
            if not name.startswith(self._series):
                self._storage.remove(f"journal/{name}")

    def prepare(self) -> None:
        """As `Log.prepare`."""

    def append(self, lines: bytes) -> None:
        """As `Log.append`."""
        self._storage.renew()
        self._add(lines)
        if not self._storage.unchanged(MANIFEST):  # another writer has folded this series, and removed its objects
            raise UsageError(f"{self._storage.place}: {_ANOTHER}")

    def seal(self) -> None:
        """As `Log.seal`: takes the next number."""
        if self._series:
            self._add(b"")

    def close(self) -> None:
        """As `Log.close`."""

    def set_aside(self) -> None:
        """As `Log.set_aside`."""
        for name in self._storage.below(self.name):
            self._storage.set_aside(f"{self.name}/{name}")
        self._series = ""

    def _add(self, lines: bytes) -> None:
        if not self._storage.publish(_name(self._series, self._next), f"{self._storage.token}\n".encode() + lines):
            raise UsageError(f"{self._storage.place}: {_ANOTHER}")
        self._next += 1


def _name(series: str, number: int) -> str:
    return f"journal/{series}-{number:08d}"


def _ended(holder: dict[str, Any]) -> bool:
    """Whether the process of a lease was one of this machine and is gone."""
    return holder["host"] == socket.gethostname() and not os.path.exists(f"/proc/{holder['pid']}")
