"""Folders of many chunks: their entries are columns and a file of their own. Here many are three."""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from rvjax.errors import FolderError, IncompleteError, UsageError
from rvjax.run_folder import RunFolder, atomic_files, local_storage
from rvjax.run_folder import journal as journals
from tests.disk import Disk, Killed, stopped_by

from .conftest import COLUMNS, LANES, chunk, create, fly, only, resume
from .test_disk_failures import EXPECTED, committed, files_of, taken

SAMPLES = 22
"""Of a run with six chunks, six envelopes and a trace: 13 entries."""

EVERY = {False: 8, True: 1}
"""One of how many calls fails, by whether the suite runs in its full numbers."""


@pytest.fixture(autouse=True)
def low_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three entries are many, and so are four lines of the journal; blocks hold two rows."""
    monkeypatch.setattr("rvjax.run_folder.journal.LISTED", 3)
    monkeypatch.setattr("rvjax.run_folder.local_storage.MOST_LINES", 4)
    monkeypatch.setattr("rvjax.run_folder.entries.RECENT", 2)
    monkeypatch.setattr("rvjax.run_folder.entries_file._BLOCK", 2)
    monkeypatch.setattr("rvjax.run_folder.stock._BLOCK", 2)


@pytest.fixture
def large(tmp_path: Path) -> Path:
    """A finished run folder with an entries file."""
    with create(tmp_path / "run", SAMPLES) as folder:
        fly(folder, SAMPLES)
    return tmp_path / "run"


def document(path: Path) -> dict[str, object]:
    """The manifest."""
    return json.loads((path / "manifest.json").read_text())


def entries_file(path: Path) -> Path:
    """The only entries file."""
    (file,) = path.glob("entries-*.parquet")
    return file


def small(path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same run in a folder whose manifest lists its files."""
    with monkeypatch.context() as patched:
        patched.setattr("rvjax.run_folder.journal.LISTED", 1_000)
        with create(path, SAMPLES) as folder:
            fly(folder, SAMPLES)
    return path


def test_the_manifest_names_the_file_of_many_entries(large: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: another format number, a SHA-256 of something else, entries that differ from those of a manifest that lists them."""
    data = entries_file(large).read_bytes()
    sha256 = atomic_files.sha256(data)
    assert document(large)["format"] == 3
    assert document(large)["entries"] == {"sha256": sha256, "count": 13}
    assert entries_file(large).name == f"entries-{sha256[:16]}.parquet"
    listing = small(tmp_path / "small", monkeypatch)
    assert (document(listing)["format"], len(document(listing)["files"])) == (2, 13)  # pyright: ignore[reportArgumentType]
    assert not list(listing.glob("entries-*"))
    assert RunFolder.open(large).chunks == RunFolder.open(listing).chunks
    pieces = [RunFolder.open(path)._store.manifest.entries for path in (large, listing)]
    assert dict(pieces[0]) == dict(pieces[1])
    RunFolder.open(large).verify()


def test_a_folder_grows_over_the_limit_and_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From a manifest of format 2 to 3 and back, with the bytes of today. Kills: an entries file that stays behind, entries of an
    older one, a folder of today that cannot be resumed."""
    path = small(tmp_path / "run", monkeypatch)
    before = (path / "manifest.json").read_bytes()
    with resume(path, SAMPLES, command="rvjax run --again"):
        pass
    assert document(path)["format"] == 3
    first = entries_file(path)
    with RunFolder.open(path) as folder:
        folder.drop_traces([3])
    assert entries_file(path) != first
    monkeypatch.setattr("rvjax.run_folder.journal.LISTED", 1_000)
    with resume(path, SAMPLES) as folder:
        fly(folder, SAMPLES)
    assert (path / "manifest.json").read_bytes() == before
    assert not list(path.glob("entries-*"))


def test_drops_make_the_manifest_small_again(large: Path) -> None:
    """Kills: a format that never goes back."""
    with RunFolder.open(large) as folder:
        folder._store.drop([key for key in folder._store.manifest.entries if key.part != "samples" or key.number > 1])
    assert document(large)["format"] == 2
    assert not list(large.glob("entries-*"))
    assert [entry.number for entry in RunFolder.open(large).chunks] == [0, 1]


def test_an_entries_file_that_fits_is_not_written_again(large: Path) -> None:
    """Kills: 30 MB that are written for another command line."""
    inode = entries_file(large).stat().st_ino
    before = (large / "manifest.json").read_bytes()
    with resume(large, SAMPLES, command="rvjax run --again"):
        pass
    assert (large / "manifest.json").read_bytes() != before
    assert entries_file(large).stat().st_ino == inode


def test_the_journal_stays_short(tmp_path: Path) -> None:
    """Kills: a journal that grows with the run, a fold that loses a line or hides what is committed."""
    with create(tmp_path / "run", 80) as folder:
        for index in range(20):
            folder.commit(index, chunk(index, 80), COLUMNS)
            assert RunFolder.open(tmp_path / "run").chunks.number.tolist() == list(range(index + 1))
            assert len((tmp_path / "run" / "journal.jsonl").read_bytes().splitlines()) <= 1 + 4
    assert document(tmp_path / "run")["entries"]["count"] == 20  # pyright: ignore[reportIndexIssue]


def test_a_run_may_go_on_behind_a_fold_that_failed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: lines added to a journal that the manifest does not know."""
    replace = atomic_files.replace

    def full(path: Path, data: bytes) -> None:
        if path.name == "journal.jsonl":
            with atomic_files.explained(path):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        replace(path, data)

    with create(tmp_path / "run", SAMPLES) as folder:
        for index in range(4):
            folder.commit(index, chunk(index, SAMPLES), COLUMNS)
        monkeypatch.setattr(atomic_files, "replace", full)
        with pytest.raises(IncompleteError, match="No space left"):
            folder.commit(4, chunk(4, SAMPLES), COLUMNS)
        monkeypatch.setattr(atomic_files, "replace", replace)
        folder.commit(5, chunk(5, SAMPLES), COLUMNS)
        assert RunFolder.open(tmp_path / "run").chunks.number.tolist() == [0, 1, 2, 3, 5]
        folder.commit(4, chunk(4, SAMPLES), COLUMNS)
    assert RunFolder.open(tmp_path / "run").chunks.number.tolist() == list(range(6))


# --- stops and damage -----------------------------------------------------------------------------------------------


def attempt(path: Path) -> None:
    """A run, new or resumed, with files that are committed together."""
    begun = (path / "manifest.json").exists()
    with resume(path, SAMPLES) if begun else create(path, SAMPLES) as folder:
        fly(folder, SAMPLES)


@pytest.mark.parametrize("error", [errno.ENOSPC, None])
def test_any_failing_call_keeps_what_was_committed(
    tmp_path: Path, error: int | None, full: bool, figure: Callable[[str], None]
) -> None:
    """Call after call fails, or the process ends there: also between entries file, manifest, journal and the removal of
    the older entries file. Kills: a manifest that names a file which is not there yet, an older entries file that is removed too
    early, one that stays for ever."""
    attempt(tmp_path / "whole")
    whole = files_of(tmp_path / "whole")
    assert sum(name.startswith("entries-") for name in whole) == 1
    fails, hits, places = 1 + (error is None), 0, set[str]()
    while True:
        path = tmp_path / f"{fails}"
        with pytest.MonkeyPatch.context() as patched:
            promised = taken(patched)
            disk = Disk(patched, path, fails, error)
            caught = stopped_by(attempt, path)
        hit = disk.calls >= fails
        assert isinstance(caught, EXPECTED[error] if hit else type(None)), disk.where
        kept = committed(path)
        assert promised <= kept.keys(), disk.where
        attempt(path)
        assert files_of(path) == whole, disk.where
        shutil.rmtree(path)
        if not hit:
            break
        hits += 1
        places.add(disk.where.split()[0] + (" of entries" if "entries-" in disk.where else ""))
        fails += EVERY[full]
    assert {"replace of entries", "unlink of entries", "fsync"} <= places or not full
    way = errno.errorcode[error] if error else "the end of the process"
    figure(f"failing calls with an entries file: {way} at {hits} of {disk.calls} calls; the same files after going on")


@pytest.mark.parametrize("step", ["entries", "manifest.json", "journal.jsonl", "removal"])
def test_a_stop_between_two_steps_of_a_fold(large: Path, step: str) -> None:
    """The process ends right after one of them. Kills: the steps in another order."""
    expected = RunFolder.open(large).chunks.number.tolist()
    replace, unlink = atomic_files.replace, Path.unlink

    def replaced(path: Path, data: bytes) -> None:
        replace(path, data)
        if path.name.startswith(step):
            raise Killed

    def removed(path: Path, missing_ok: bool = False) -> None:
        unlink(path, missing_ok)
        if step == "removal" and path.name.startswith("entries-"):
            raise Killed

    before = {file.name for file in large.glob("entries-*")}
    folder = RunFolder.open(large)
    folder.commit(6, chunk(6, 40), COLUMNS)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(atomic_files, "replace", replaced)
        patched.setattr(Path, "unlink", removed)
        with pytest.raises(Killed):
            folder.close()
    there = {file.name for file in large.glob("entries-*")}
    assert before < there if step != "removal" else before.isdisjoint(there)
    seen = RunFolder.open(large)
    assert seen.chunks.number.tolist() == [*expected, 6]
    assert {file.name for file in large.glob("entries-*")} == there, "a reader removes nothing"
    with RunFolder.open(large) as folder:
        folder.drop_traces([])
    entries_file(large)
    assert RunFolder.open(large).chunks.number.tolist() == [*expected, 6]


def test_a_bit_anywhere_in_the_entries_file_is_noticed(large: Path) -> None:
    """Kills: entries that are believed without their SHA-256, a message that does not say what to do."""
    path = entries_file(large)
    good = path.read_bytes()
    changes = [good[:-1], b"", None]
    for place in range(0, len(good), 7):
        changed = bytearray(good)
        changed[place] ^= 1 << place % 8
        changes.append(bytes(changed))
    for data in changes:
        path.unlink()
        if data is not None:
            path.write_bytes(data)
        with pytest.raises(FolderError, match=rf"{path.name}: (damaged|missing).*`rvjax doctor`"):
            RunFolder.open(large)
        path.write_bytes(good)
    RunFolder.open(large).verify()


def test_a_damaged_entries_file_is_rebuilt(large: Path) -> None:
    """Kills: a rebuild that needs what is damaged, one that forgets chunks, a damaged file that stays."""
    good = files_of(large)
    path = entries_file(large)
    path.write_bytes(path.read_bytes()[:-1] + b"x")
    with RunFolder.rebuild(large) as folder:
        folder.verify()
    assert files_of(large) == good
    assert any(file.name.startswith(path.name) for file in (large / "quarantine").iterdir())


# --- several processes ----------------------------------------------------------------------------------------------


def test_a_reader_follows_a_writer_that_folds(large: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The manifest is replaced between its bytes and those of its entries. Kills: a reader that calls this damage."""
    read, writes = atomic_files.read, [6, 7]

    def late(path: Path) -> bytes:
        data = read(path)
        if path.name == "manifest.json" and writes:
            index = writes.pop(0)
            with monkeypatch.context() as patched:
                patched.setattr(atomic_files, "read", read)
                with RunFolder.open(large) as folder:
                    folder.commit(index, chunk(index, 40), COLUMNS)
        return data

    monkeypatch.setattr(atomic_files, "read", late)
    assert RunFolder.open(large).chunks.number.tolist() == list(range(8))


def test_a_writer_sees_what_another_has_folded_since(large: Path) -> None:
    """And two cannot write at a time. Kills: entries that were read before the folder was claimed."""
    first = RunFolder.open(large)
    with RunFolder.open(large) as second:
        second.commit(6, chunk(6, 40), COLUMNS)
        with pytest.raises(UsageError, match="another process is writing"):
            first.commit(7, chunk(7, 40), COLUMNS)
    with first:
        first.commit(7, chunk(7, 40), COLUMNS)
    assert RunFolder.open(large).chunks.number.tolist() == list(range(8))
    entries_file(large)


def test_resuming_finds_what_the_disk_lacks_and_has_more(large: Path) -> None:
    """Kills: an entry without a file, a file of another size that counts, a whole file that is flown again."""
    stray = only(large, "samples/00004")
    with RunFolder.open(large) as folder:
        entry = folder._store.manifest.entries.pop(folder.chunks[4].key)
    only(large, "samples/00001").unlink()
    cut = only(large, "envelopes/00002")
    cut.write_bytes(cut.read_bytes()[:-1])
    (large / "samples" / "12345678901234567890-0123456789abcdef.parquet").write_bytes(b"x")
    (large / "samples" / "left over").write_bytes(b"x")
    with resume(large, SAMPLES) as folder:
        assert folder.missing(6, 6) == [1, 2]
        assert folder.chunks[-2] == entry
        fly(folder, SAMPLES)
    assert stray.exists()
    assert len(list((large / "quarantine").iterdir())) == 3
    RunFolder.open(large).verify()


def test_limits_are_those_of_a_large_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the tests lower. Kills: a limit that makes today's folders look different, one that is never reached."""
    monkeypatch.undo()
    assert 1_000 < journals.LISTED < local_storage.MOST_LINES < 100_000
    assert LANES == 4
