"""Every call to the file system may fail, or be the last one: what was committed stays, and the run can go on."""

from __future__ import annotations

import errno
import os
import shutil
import stat
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest

from rvjax.errors import FolderError, IncompleteError
from rvjax.run_folder import DataFile, RunFolder, atomic_files
from tests.disk import Disk, Killed, stopped_by

from .conftest import COLUMNS, chunk, create, fly, only, resume

SAMPLES = 7

EVERY = {False: 3, True: 1}
"""One of how many calls fails, by whether the suite runs in its full numbers."""

EXPECTED = {errno.ENOSPC: IncompleteError, errno.EIO: IncompleteError, errno.EROFS: FolderError, None: Killed}


def files_of(path: Path) -> dict[str, bytes]:
    """All files but those that were set aside."""
    return {file.name: file.read_bytes() for file in path.rglob("*") if file.is_file() and file.parent.name != "quarantine"}


def committed(path: Path, damaged: bool = False) -> dict[str, bytes]:
    """The whole files of the manifest on the disk; nothing where there is none yet. damaged: some may be not whole."""
    if not (path / "manifest.json").exists():
        return {}
    folder = RunFolder.open(path)
    if not damaged:
        folder.verify()
    data = {entry: path / entry.file for entry in folder.chunks}
    there = {entry.file: (file.read_bytes(), entry.sha256) for entry, file in data.items() if file.exists() or not damaged}
    return {name: found for name, (found, sha256) in there.items() if atomic_files.sha256(found) == sha256}


def attempt(path: Path) -> None:
    """A run, new or resumed."""
    if (path / "manifest.json").exists():
        with resume(path, SAMPLES) as folder:
            fly(folder, SAMPLES)
    else:
        with create(path, SAMPLES) as folder:
            fly(folder, SAMPLES)


def taken(monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """The chunks that a run was told are committed, from now on."""
    promised: set[str] = set()
    take_all = RunFolder.take_all

    def noted(folder: RunFolder, files: Iterable[DataFile]) -> None:
        files = list(files)
        take_all(folder, files)
        promised.update(file.entry.file for file in files if file.entry.file.startswith("samples/"))

    monkeypatch.setattr(RunFolder, "take_all", noted)
    return promised


def interrupted(path: Path) -> None:
    """What a process leaves that ended before it closed the folder: lines in the journal, half a file; and a damaged chunk."""
    with create(path.with_name("open"), SAMPLES) as folder:
        fly(folder, SAMPLES)
        shutil.copytree(folder.path, path)
    damaged = only(path, "samples/00000")
    damaged.write_bytes(damaged.read_bytes()[:-1] + b"x")
    only(path, "samples/00001").rename(path / "samples" / f".{'0' * 32}.{'0' * 32}")


@pytest.mark.parametrize("begun", [False, True])
@pytest.mark.parametrize("error", EXPECTED)
def test_any_failing_call_keeps_what_was_committed(
    tmp_path: Path, error: int | None, begun: bool, full: bool, figure: Callable[[str], None]
) -> None:
    """Call after call, with an errno or as the process's end, in a new folder and in a resumed folder; then the
    run is resumed and ends with the same files.

    Kills: writing in place, a line of the journal before its file, a journal emptied before the manifest has its lines, a
    temporary file taken for a chunk, a raw OSError, a lock that outlives its owner, a damaged file that is lost before it is set
    aside.
    """
    if error == errno.EROFS and begun and not full:
        pytest.skip("a disk that turns read-only: with --long")
    attempt(tmp_path / "whole")
    interrupted(tmp_path / "template")
    whole = files_of(tmp_path / "whole")
    fails = 1 + (list(EXPECTED).index(error) * 2 + begun) % EVERY[full]  # another share of the calls each time
    hits = 0
    while True:
        path = tmp_path / f"{fails}"
        if begun:
            shutil.copytree(tmp_path / "template", path)
        with pytest.MonkeyPatch.context() as monkeypatch:
            promised = taken(monkeypatch)
            disk = Disk(monkeypatch, path, fails, error)
            caught = stopped_by(attempt, path)
        hit = disk.calls >= fails
        assert isinstance(caught, EXPECTED[error] if hit else type(None)), disk.where
        if error is not None and hit:
            assert os.strerror(error) in str(caught)
            assert "give" in str(caught), "the message says what to do"
        kept = committed(path, begun)
        assert promised <= kept.keys(), disk.where
        attempt(path)
        assert kept.items() <= committed(path).items()
        assert files_of(path) == whole, disk.where
        if begun:
            (damaged,) = (path / "quarantine").iterdir()
            assert damaged.read_bytes()[-1:] == b"x"
        shutil.rmtree(path)
        if not hit:
            break
        hits += 1
        fails += EVERY[full]
    assert hits > 40 // EVERY[full]
    way = errno.errorcode[error] if error else "the end of the process"
    what = "goes on with" if begun else "begins"
    figure(f"failing calls: {way} at {hits} of {disk.calls} calls of a run that {what} a folder; the same files after going on")


def test_a_run_may_go_on_behind_a_line_that_did_not_fit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What else had been flown is still handed over. Kills: half a line left in front of the next one."""
    with create(tmp_path / "run") as folder:
        folder.commit(0, chunk(0, 10), COLUMNS)
        write = os.write
        monkeypatch.setattr(os, "write", lambda handle, data: write(handle, data[:30]))
        with pytest.raises(IncompleteError, match="No space left"):
            folder.commit(1, chunk(1, 10), COLUMNS)
        monkeypatch.undo()
        folder.commit(2, chunk(2, 10), COLUMNS)
        assert [entry.number for entry in RunFolder.open(tmp_path / "run").chunks] == [0, 2]


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
    atomic_files.publish(tmp_path / "a", b"x")
    atomic_files.replace(tmp_path / "b", b"y")
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
