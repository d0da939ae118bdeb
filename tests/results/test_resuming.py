"""A run folder is resumed: intact data stay, missing or damaged data are flown, another run's folder is refused."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pyarrow as pa
import pytest

from rvjax.errors import FolderError, IncompleteError, UsageError
from rvjax.run_folder import Column, RunDescription, RunFolder, atomic_files

from .conftest import COLUMNS, IDENTITY, LANES, chunk, create, fly, lacking, only, resume


def test_resume_refuses_another_identity_and_says_where(finished: Path) -> None:
    """Kills: a comparison of hashes, which cannot say what differs; parts that only one side has."""
    other = {"campaign": "cd34", "device": {"kind": "gpu"}, "lanes": [LANES], "precision": "float32"}
    with pytest.raises(FolderError) as caught:
        resume(finished, 10, other)
    assert str(caught.value).splitlines()[1:] == [
        'campaign: the folder has "ab12", this run has "cd34"',
        'device.kind: the folder has "cpu", this run has "gpu"',
        'precision: the folder has nothing, this run has "float32"',
        "seed: the folder has 7, this run has nothing",
    ]
    with pytest.raises(UsageError, match="10 samples were requested before, now 9; resume with --samples 10 or more"):
        resume(finished, 9)


def test_more_samples_fly_only_what_is_new_and_what_was_cut_short(tmp_path: Path, finished: Path) -> None:
    """Kills: a last chunk that stays short, one that is flown again although it was full."""
    with resume(finished, 16) as folder:
        assert folder.missing(4) == [2, 3]
        fly(folder, 16)
    with create(tmp_path / "whole", 16) as folder:
        fly(folder, 16)
    assert (finished / "manifest.json").read_bytes() == (tmp_path / "whole" / "manifest.json").read_bytes()
    with resume(finished, 16) as folder:
        assert folder.missing(4) == []


def test_a_whole_last_chunk_stays_when_samples_grow(tmp_path: Path) -> None:
    """Kills: a chunk flown again although all its lanes hold samples."""
    with create(tmp_path / "run", 8) as folder:
        fly(folder, 8)
    with resume(tmp_path / "run", 16) as folder:
        assert folder.missing(4) == [2, 3]
    assert not (tmp_path / "run" / "quarantine").exists()


def test_what_is_no_part_of_the_identity_is_what_was_said_last(finished: Path) -> None:
    """Requirements may change between two runs of one campaign. Kills: verdicts on the old ones; a damaged campaign file that
    nothing repairs; the first start forgotten."""
    (finished / "campaign.yaml").write_text("rvjax: 2\n")
    with pytest.raises(FolderError, match="damaged or edited"):
        RunFolder.open(finished).campaign_text()
    with resume(finished, 10, text="rvjax: 1\nrequire: []\n", command="rvjax run --again") as folder:
        assert folder.missing(3) == []
    again = RunFolder.open(finished)
    assert again.campaign_text() == "rvjax: 1\nrequire: []\n"
    assert again.provenance["command"] == "rvjax run --again"
    again.verify()


def test_dropped_traces_are_gone(finished: Path) -> None:
    with RunFolder.open(finished) as folder:
        folder.drop_traces([3])
    assert RunFolder.open(finished).trace_samples() == []
    assert not list((finished / "traces").iterdir())


def test_damaged_chunk_is_set_aside_and_flown_again(finished: Path) -> None:
    """Also with its histories or its trace damaged. Kills: trusting a file by its name."""
    before = (finished / "manifest.json").read_bytes()
    for name, missing in (("samples/00001", [1]), ("envelopes/00002", [2]), ("traces/sample-0000003", [])):
        path = only(finished, name)
        data = path.read_bytes()
        for damaged in (data[:-1], data[:-1] + b"x"):
            path.write_bytes(damaged)
            with resume(finished, 10) as folder:
                assert lacking(folder) == missing
                fly(folder)
            assert (finished / "manifest.json").read_bytes() == before
            RunFolder.open(finished).verify()
    assert len(list((finished / "quarantine").iterdir())) == 6


def test_first_of_two_writers_wins(finished: Path) -> None:
    """The same bytes are welcome twice, others are an alarm. Kills: os.replace for os.link."""
    path = only(finished, "samples/00000")
    inode = path.stat().st_ino
    with RunFolder.open(finished) as folder:
        folder.commit(0, chunk(0, 10), COLUMNS)
        assert path.stat().st_ino == inode
        with pytest.raises(FolderError, match="the same identity must give the same bytes"):
            folder.commit(0, chunk(0, 10).assign(outcome="captured"), COLUMNS)
        assert path.stat().st_ino == inode
        assert len(folder.chunks) == 3
    assert not atomic_files.publish(path, b"other")
    assert atomic_files.publish(path, path.read_bytes())


def test_one_process_writes_at_a_time(finished: Path) -> None:
    """Readers may come any time. Kills: two runs that overwrite each other's manifest."""
    with resume(finished, 10):
        with pytest.raises(UsageError, match="another process is writing"):
            resume(finished, 10)
        RunFolder.open(finished).verify()
    with resume(finished, 10):
        pass


def test_what_was_committed_is_there_at_once_for_others(tmp_path: Path) -> None:
    """One line of the journal a file, the manifest left alone until closing. Kills: a rewrite per chunk (quadratic), a line that
    waits for the next one."""
    with create(tmp_path / "run", 40) as folder:
        before = (tmp_path / "run" / "manifest.json").read_bytes()
        for index in range(6):
            folder.commit(index, chunk(index, 40), COLUMNS)
            assert len(RunFolder.open(tmp_path / "run").chunks) == index + 1
            assert len((tmp_path / "run" / "journal.jsonl").read_bytes().splitlines()) == index + 2
        assert (tmp_path / "run" / "manifest.json").read_bytes() == before
    assert len((tmp_path / "run" / "journal.jsonl").read_bytes().splitlines()) == 1
    assert len(RunFolder.open(tmp_path / "run").chunks) == 6


def test_a_folder_that_is_as_it_should_be_is_not_written_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Manifest and journal stay the files they are, and lines are added behind the one that is there. Kills: seconds for each
    of three rewrites of a large manifest; a length of the journal that is not known, so that half a line takes the first away.
    """
    path = tmp_path / "run"
    with create(path) as folder:
        folder.commit(0, chunk(0, 10), COLUMNS)
    before = [(path / name).stat().st_ino for name in ("manifest.json", "journal.jsonl")]
    with resume(path, 10) as folder:
        pass
    with resume(path, 10) as folder:
        assert [(path / name).stat().st_ino for name in ("manifest.json", "journal.jsonl")] == before
        write = os.write
        monkeypatch.setattr(os, "write", lambda handle, data: write(handle, data[:30]))
        with pytest.raises(IncompleteError):
            folder.commit(1, chunk(1, 10), COLUMNS)
        monkeypatch.undo()
        folder.commit(2, chunk(2, 10), COLUMNS)
        assert [entry.number for entry in RunFolder.open(path).chunks] == [0, 2]
    with resume(path, 10, command="rvjax run --again"):
        assert [(path / name).stat().st_ino for name in ("manifest.json", "journal.jsonl")] != before
    assert RunFolder.open(path).provenance["command"] == "rvjax run --again"


def test_half_a_line_alone_is_not_written_behind(tmp_path: Path) -> None:
    """Kills: a journal with a rest in it that is taken for one that is as it should be."""
    with create(tmp_path / "run") as folder:
        folder.commit(0, chunk(0, 10), COLUMNS)
    with (tmp_path / "run" / "journal.jsonl").open("ab") as file:
        file.write(b'["0123456789abcdef", {"fi')
    with resume(tmp_path / "run", 10) as folder:
        folder.commit(1, chunk(1, 10), COLUMNS)
        assert [entry.number for entry in RunFolder.open(tmp_path / "run").chunks] == [0, 1]


def test_a_stop_while_a_line_goes_to_the_disk_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The others see the line before it is certain to stay. Kills: a manifest without the chunk whose line was interrupted."""

    whole = os.fsync

    def stop(handle: int) -> None:
        if os.readlink(f"/proc/self/fd/{handle}").endswith("journal.jsonl"):
            raise KeyboardInterrupt
        whole(handle)

    with create(tmp_path / "run") as folder:
        monkeypatch.setattr(os, "fsync", stop)
        with pytest.raises(KeyboardInterrupt):
            folder.commit(0, chunk(0, 10), COLUMNS)
        monkeypatch.undo()
    assert [entry.number for entry in RunFolder.open(tmp_path / "run").chunks] == [0]


def test_whoever_comes_to_write_sees_what_was_written_since(tmp_path: Path) -> None:
    """Kills: going on from what was read before the folder was claimed."""
    with create(tmp_path / "run") as folder:
        folder.commit(0, chunk(0, 10), COLUMNS)
    first = RunFolder.open(tmp_path / "run")
    with RunFolder.open(tmp_path / "run") as second:
        second.commit(1, chunk(1, 10), COLUMNS)
    with first:
        first.commit(2, chunk(2, 10), COLUMNS)
        assert [entry.number for entry in first.chunks] == [0, 1, 2]
    assert [entry.number for entry in RunFolder.open(tmp_path / "run").chunks] == [0, 1, 2]


def test_a_line_cut_short_is_no_damage_and_its_file_is_taken_in(tmp_path: Path) -> None:
    """What a process that ended in the middle of a line leaves. Kills: a journal that nobody can read any more, a chunk flown
    twice, a line glued to the rest of another."""
    path = tmp_path / "run"
    with create(path) as folder:
        fly(folder)
        torn = {file.relative_to(path): file.read_bytes() for file in path.rglob("*") if file.is_file()}
    whole = (path / "manifest.json").read_bytes()
    text = torn[Path("journal.jsonl")]
    for cut in range(text.index(b"\n") + 1, len(text), 37):
        for file, data in torn.items():
            (path / file).write_bytes(data)
        (path / "journal.jsonl").write_bytes(text[:cut])
        assert len(RunFolder.open(path).chunks) == sum(b"samples/" in line for line in text[:cut].split(b"\n")[:-1])
        with resume(path, 10) as folder:
            assert folder.missing(3, 3) == []
        assert (path / "manifest.json").read_bytes() == whole


def test_a_file_that_never_reached_the_manifest_is_taken_in_if_it_is_whole(tmp_path: Path, finished: Path) -> None:
    """Its name says what it must hold, its metadata of which run it is. Kills: flying it again; adopting half a file, or one of
    another run."""
    entry = RunFolder.open(finished).chunks[1]
    data = (finished / entry.file).read_bytes()
    with create(tmp_path / "new") as folder:
        (tmp_path / "new" / "samples").mkdir()
        (tmp_path / "new" / entry.file).write_bytes(data)
        (tmp_path / "new" / entry.file.replace("00001", "00002")).write_bytes(data[:-1])
        (tmp_path / "new" / "samples" / "00000.parquet").write_bytes(b"left over")
    with resume(tmp_path / "new", 10) as folder:
        assert folder.chunks == (entry,)
        assert folder.missing(3) == [0, 2]
        assert len(list((tmp_path / "new" / "quarantine").iterdir())) == 2
        fly(folder)
        folder.verify()
        assert folder.account().missing == 0
    description = RunDescription(
        identity=IDENTITY | {"seed": 8}, provenance={}, campaign_text="rvjax: 1\n", samples=10, name="small"
    )
    with RunFolder.create(tmp_path / "other", description):
        (tmp_path / "other" / "samples").mkdir()
        (tmp_path / "other" / entry.file).write_bytes(data)
    with RunFolder.resume(tmp_path / "other", description, LANES) as folder:
        assert folder.chunks == ()


def test_two_whole_files_of_one_chunk_are_an_alarm(finished: Path, tmp_path: Path) -> None:
    """Kills: taking whichever comes first."""
    with create(tmp_path / "new") as folder:
        folder.commit(1, chunk(1, 10).assign(outcome="captured"), COLUMNS)
    (stray,) = (tmp_path / "new" / "samples").iterdir()
    (finished / "samples" / stray.name).write_bytes(stray.read_bytes())
    with pytest.raises(FolderError, match="the same identity must give the same bytes"):
        resume(finished, 10)


def test_the_same_table_in_other_bytes_is_no_alarm(finished: Path) -> None:
    """Another version of the library that encodes may write a chunk again. Kills: comparing files instead of tables."""
    table = pa.table({name: pa.array(chunk(1, 10)[name].to_numpy()) for name in chunk(1, 10)})
    renamed = {name: Column(name, column.unit, column.description + "!") for name, column in COLUMNS.items()}
    with RunFolder.open(finished) as folder:
        before = folder.chunks
        folder.commit(1, table, renamed)
        assert folder.chunks == before
        assert len(list((finished / "samples").iterdir())) == 3


def test_manifest_and_journal_are_made_again_from_the_files(finished: Path) -> None:
    """Either may be damaged or gone. Kills: a chunk that is not found again, a damaged file that is, an old head."""
    manifest, journal = finished / "manifest.json", finished / "journal.jsonl"
    good = manifest.read_bytes(), journal.read_bytes()
    bad = only(finished, "samples/00002")
    for path in (manifest, journal):
        for data in (None, b"", path.read_bytes()[:-7]):
            path.unlink(missing_ok=True)
            if data is not None:
                path.write_bytes(data)
            with RunFolder.rebuild(finished) as folder:
                folder.verify()
            assert (manifest.read_bytes(), journal.read_bytes()) == good
    bad.write_bytes(bad.read_bytes()[:-1])
    manifest.unlink()
    with RunFolder.rebuild(finished) as folder:
        assert folder.missing(3) == [2]
        folder.verify()
    manifest.unlink()
    journal.unlink()
    with pytest.raises(FolderError, match=r"neither manifest\.json nor journal\.jsonl is whole"):
        RunFolder.rebuild(finished)


def test_a_file_that_may_not_be_read_is_no_damage(finished: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: setting aside, and flying again, what only somebody's rights keep from being read."""
    honest = Path.read_bytes

    def refused(path: Path) -> bytes:
        if path.parent.name in ("samples", "envelopes"):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return honest(path)

    with resume(finished, 10) as folder:
        monkeypatch.setattr(Path, "read_bytes", refused)
        for reading in (
            lambda: folder.quarantine_damaged(["envelopes"]),
            lambda: list(folder.read_valid_chunks([0])),
            folder.verify,
        ):
            with pytest.raises(FolderError, match="give yourself access"):
                reading()
        monkeypatch.undo()
    assert not (finished / "quarantine").exists()
