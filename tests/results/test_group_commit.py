"""Many data files are committed together: synced once, and as safe at every instant as each by itself."""

from __future__ import annotations

import os
import shutil
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rvjax.errors import FolderError, IncompleteError
from rvjax.run_folder import DataFile, RunFolder
from rvjax.run_folder.entry import Key
from rvjax.run_folder.local_storage import LocalStorage
from tests.disk import Disk, Killed

from .conftest import COLUMNS, chunk, create, history, resume

SAMPLES = 16


def group(folder: RunFolder, numbers: range = range(4)) -> list[DataFile]:
    """The envelopes and samples of some chunks, not written yet."""
    tables = [(Key("envelopes", number), history(number, SAMPLES)) for number in numbers]
    tables += [(Key("samples", number), chunk(number, SAMPLES)) for number in numbers]
    return [DataFile.of(key, table, COLUMNS, folder.digest) for key, table in tables]


def test_a_group_is_the_same_folder_as_its_files_in_turn(tmp_path: Path) -> None:
    """Kills: a file of a group that is forgotten, files in another order."""
    for name, together in (("turn", False), ("group", True)):
        with create(tmp_path / name, SAMPLES) as folder:
            files = group(folder)
            for part in [files] if together else [[file] for file in files]:
                folder.take_all(part)
            assert folder.missing(4, 4) == []
            assert len(RunFolder.open(tmp_path / name).chunks) == 4, "others see them at once"
    assert (tmp_path / "turn" / "manifest.json").read_bytes() == (tmp_path / "group" / "manifest.json").read_bytes()


def test_names_are_durable_before_the_lines_and_synced_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a line before its file, a sync for each file where one does, a folder that is not synced."""
    order: list[str] = []

    def noted(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def note(*arguments: Any, **options: Any) -> Any:
            place = Path(os.readlink(f"/proc/self/fd/{arguments[0]}")) if isinstance(arguments[0], int) else Path(arguments[0])
            what = place.name if place.suffix == ".jsonl" or place.is_dir() else "file"
            order.append(f"{name} {what}")
            return call(*arguments, **options)

        return note

    with create(tmp_path / "run", SAMPLES) as folder:
        folder.take_all(group(folder, range(1)))  # the folders are there from now on
        files = group(folder, range(1, 4))
        for name in ("link", "fsync", "write"):
            monkeypatch.setattr(os, name, noted(name, getattr(os, name)))
        folder.take_all(files)
        folder.take_all(files)  # there already: nothing is to be made durable
        monkeypatch.undo()
    ends = ["fsync envelopes", "fsync samples", "write journal.jsonl", "fsync journal.jsonl"]
    assert order == ["fsync file", "link file"] * 6 + ends


def test_a_stop_at_any_call_of_a_group_loses_nothing(tmp_path: Path) -> None:
    """Kills: a durable line without its file; a file without a line that is not recognised; a journal that nobody can read."""
    with create(tmp_path / "template", SAMPLES) as folder:
        files = group(folder)
    calls, hits = 1, 0
    while True:
        path = tmp_path / f"{calls}"
        shutil.copytree(tmp_path / "template", path)
        with pytest.MonkeyPatch.context() as monkeypatch:
            disk = Disk(monkeypatch, path, calls, None)
            try:
                with RunFolder.open(path) as folder:
                    folder.take_all(files)
            except Killed:
                hits += 1
        names = {file.relative_to(path).as_posix() for file in path.glob("*/*.parquet") if not file.name.startswith(".")}
        RunFolder.open(path).verify()  # what is listed is whole
        with resume(path, SAMPLES) as folder:
            entries = {file.entry.file for file in files} & names
            assert {entry.file for entry in folder.chunks} == {name for name in entries if name.startswith("samples/")}, (
                disk.where
            )
            folder.take_all(files)
            assert folder.missing(4, 4) == []
            folder.verify()
        assert not (path / "quarantine").exists(), disk.where
        shutil.rmtree(path)
        if disk.calls < calls:
            break
        calls += 1
    assert hits > 30


def test_lines_that_did_not_fit_commit_no_file_of_the_group(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: entries without lines, and lines that stay although the group failed."""
    with create(tmp_path / "run", SAMPLES) as folder:
        files = group(folder)
        folder.take_all(files[-1:])
        write = os.write
        monkeypatch.setattr(os, "write", lambda handle, data: write(handle, data[: len(data) // 2]))
        with pytest.raises(IncompleteError, match="No space left"):
            folder.take_all(files)
        monkeypatch.undo()
        assert folder.missing(4) == [0, 1, 2]
        assert [entry.number for entry in RunFolder.open(tmp_path / "run").chunks] == [3]
        folder.take_all(files)
        assert folder.missing(4, 4) == []
    assert len(RunFolder.open(tmp_path / "run").chunks) == 4


def test_two_tables_of_one_chunk_in_a_group_are_an_alarm(tmp_path: Path) -> None:
    """The same file twice is welcome. Kills: comparing only with what was committed before the group."""
    with create(tmp_path / "run", SAMPLES) as folder:
        files = group(folder, range(1))
        folder.take_all([*files, *files])
        assert len((tmp_path / "run" / "journal.jsonl").read_bytes().splitlines()) == 1 + len(files)
        table = chunk(1, SAMPLES)
        tables = (table, table.assign(outcome="captured"))
        pair = [DataFile.of(Key("samples", 1), frame, COLUMNS, folder.digest) for frame in tables]
        with pytest.raises(FolderError, match="the same identity must give the same bytes"):
            folder.take_all(pair)
        assert folder.missing(2) == [1]


def test_a_file_that_a_worker_has_written_is_compared(tmp_path: Path) -> None:
    """Kills: a line for a file that is damaged or not there."""
    with create(tmp_path / "run", SAMPLES) as folder:
        first, second = group(folder, range(1))
        written = first.put(LocalStorage(tmp_path / "run"))
        with pytest.raises(FolderError, match="missing, but"):
            folder.take_all([written, DataFile(second.entry, None)])
        assert stat.S_ISREG((tmp_path / "run" / first.entry.file).stat().st_mode)
        folder.take_all([written, second])
        assert folder.missing(1, 1) == []
