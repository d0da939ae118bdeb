"""Every call to the file system may fail, or be the last one: what was committed stays, and the run can go on."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rvjax.errors import FolderError, IncompleteError, RvjaxError
from rvjax.results import RunFolder, files

from .conftest import create, fly, resume


class Killed(BaseException):
    """The process ends here: nothing after it happens, not even the clean-up."""


SAMPLES = 7

EXPECTED = {errno.ENOSPC: IncompleteError, errno.EROFS: FolderError, None: Killed}


class Disk:
    """Counts the calls that change the disk; number `fails` raises an errno, or it and all after it the end."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, fails: int, error: int | None) -> None:
        self.calls, self.fails, self.error = 0, fails, error
        for name in ("link", "replace", "rename", "fsync", "mkdir", "unlink", "ftruncate"):
            monkeypatch.setattr(os, name, self.watched(getattr(os, name)))
        monkeypatch.setattr(os, "write", self.torn(os.write))
        opened = Path.open
        monkeypatch.setattr(Path, "open", lambda path, mode="r": Torn(self, self.watched(opened)(path, mode)))

    def watched(self, call: Callable[..., Any]) -> Callable[..., Any]:
        def step(*arguments: Any, **options: Any) -> Any:
            self.step()
            return call(*arguments, **options)

        return step

    def torn(self, write: Callable[..., int]) -> Callable[..., int]:
        """A write that may stop half-way."""

        def step(handle: int, data: bytes) -> int:
            write(handle, data[: len(data) // 2])
            self.step()
            return len(data) // 2 + write(handle, data[len(data) // 2 :])

        return step

    def step(self) -> None:
        self.calls += 1
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
        self.disk.step()
        self.file.write(data[len(data) // 2 :])


def committed(path: Path) -> dict[str, bytes]:
    """The files of the manifest on the disk; nothing where there is none yet."""
    if not (path / "manifest.json").exists():
        return {}
    folder = RunFolder.open(path)
    folder.verify()
    return {entry.file: (path / entry.file).read_bytes() for entry in folder.chunks}


def attempt(path: Path) -> None:
    """A run, new or resumed."""
    if (path / "manifest.json").exists():
        with resume(path, SAMPLES) as folder:
            fly(folder, SAMPLES)
    else:
        with create(path, SAMPLES) as folder:
            fly(folder, SAMPLES)


def outcome(path: Path) -> BaseException | None:
    """What stopped a run."""
    try:
        attempt(path)
    except (RvjaxError, Killed) as caught:
        return caught
    return None


@pytest.mark.parametrize("error", EXPECTED)
def test_any_failing_call_keeps_what_was_committed(tmp_path: Path, error: int | None) -> None:
    """Every call site in turn, with an errno or as the process's end; then the run goes on to the same files.

    Kills: writing in place, a line of the journal before its file, half a line left in front of the next one, a temporary
    file taken for a chunk, a raw OSError, a lock that outlives its owner.
    """
    attempt(tmp_path / "whole")
    whole = {path.name: path.read_bytes() for path in (tmp_path / "whole").rglob("*") if path.is_file()}
    fails = 0
    while True:
        fails += 1
        path = tmp_path / f"{fails}"
        with pytest.MonkeyPatch.context() as monkeypatch:
            disk = Disk(monkeypatch, fails, error)
            caught = outcome(path)
        interrupted = disk.calls >= fails
        assert isinstance(caught, EXPECTED[error] if interrupted else type(None))
        if error is not None and interrupted:
            assert os.strerror(error) in str(caught)
            assert "give" in str(caught), "the message says what to do"
        kept = committed(path)
        attempt(path)
        assert kept.items() <= committed(path).items()
        left = {file.name: file.read_bytes() for file in path.rglob("*") if file.is_file()}
        assert left == whole
        if not interrupted:
            break
    assert fails > 40


def test_bytes_are_durable_before_they_have_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """File synced, then named, then the name synced. Kills: either fsync left out, a name given too early."""
    order: list[str] = []

    def noted(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def note(*arguments: Any, **options: Any) -> Any:
            folder = name == "fsync" and stat.S_ISDIR(os.fstat(arguments[0]).st_mode)
            order.append("fsync folder" if folder else name)
            return call(*arguments, **options)

        return note

    for name in ("link", "replace", "fsync", "unlink"):
        monkeypatch.setattr(os, name, noted(name, getattr(os, name)))
    files.publish(tmp_path / "a", b"x")
    files.replace(tmp_path / "b", b"y")
    assert order == ["fsync", "link", "unlink", "fsync folder", "fsync", "replace", "unlink", "fsync folder"]


def test_what_the_disk_gives_back_is_compared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: trusting that a write that returns has written."""
    with create(tmp_path / "run") as folder:
        monkeypatch.setattr(Path, "read_bytes", lambda _: b"other")
        with pytest.raises(IncompleteError, match="gave back other bytes"):
            fly(folder)
        monkeypatch.undo()
        assert folder.missing(3) == [0, 1, 2]
        assert not list((tmp_path / "run").rglob("*.parquet*"))
