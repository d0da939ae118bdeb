"""A disk on which one call fails, or at which the process ends."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rvjax.errors import RvjaxError

CALLS = ("link", "replace", "rename", "fsync", "mkdir", "unlink", "ftruncate")


class Killed(BaseException):
    """The process ends here: nothing after it happens, not even the clean-up."""


class Disk:
    """Counts the calls below `root` that open files or change the disk; number `fails` raises an errno, or it and all after it
    the end. where: what failed. Nothing that only reads is refused with EROFS."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, root: Path, fails: int, error: int | None) -> None:
        self.root, self.calls, self.fails, self.error, self.where = str(root), 0, fails, error, ""
        for name in CALLS:
            monkeypatch.setattr(os, name, self.watched(name, getattr(os, name)))
        monkeypatch.setattr(os, "write", self.torn(os.write))
        opened = Path.open

        def watched_open(path: Path, mode: str = "r", *arguments: Any, **options: Any) -> Any:
            concerned = self.concerns(path) and not (error == errno.EROFS and "r" in mode)
            if concerned:
                self.step("open", path)
            file = opened(path, mode, *arguments, **options)
            return Torn(self, file) if concerned else file

        monkeypatch.setattr(Path, "open", watched_open)

    def concerns(self, place: Any) -> bool:
        """Whether a path, or the file behind a handle, is below the root."""
        if isinstance(place, int):
            try:
                place = os.readlink(f"/proc/self/fd/{place}")
            except OSError:
                return False
        return os.path.abspath(os.fspath(place)).startswith(self.root)

    def watched(self, name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def step(*arguments: Any, **options: Any) -> Any:
            if self.concerns(arguments[0]):
                self.step(name, arguments[0])
            return call(*arguments, **options)

        return step

    def torn(self, write: Callable[..., int]) -> Callable[..., int]:
        """A write that may stop half-way."""

        def step(handle: int, data: bytes) -> int:
            if not self.concerns(handle):
                return write(handle, data)
            write(handle, data[: len(data) // 2])
            self.step("write", handle)
            return len(data) // 2 + write(handle, data[len(data) // 2 :])

        return step

    def step(self, name: str, place: Any) -> None:
        """One more call."""
        self.calls += 1
        if self.calls == self.fails:
            self.where = f"{name} {place}"
        if self.error is None and self.calls >= self.fails:
            raise Killed
        if self.error is not None and self.calls == self.fails:
            raise OSError(self.error, os.strerror(self.error))


class Torn:
    """A file whose write may stop half-way."""

    def __init__(self, disk: Disk, file: Any) -> None:
        self.disk, self.file = disk, file

    def __enter__(self) -> Torn:
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.file, name)

    def write(self, data: bytes) -> None:
        self.file.write(data[: len(data) // 2])
        self.disk.step("write", self.file.name)
        self.file.write(data[len(data) // 2 :])


def stopped_by(attempt: Callable[[Path], object], path: Path) -> BaseException | None:
    """What stopped an attempt: an error with a message, or the end of the process; None if it came to its end."""
    try:
        attempt(path)
    except (RvjaxError, Killed) as caught:
        return caught
    return None
