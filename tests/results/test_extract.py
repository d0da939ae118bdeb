"""The extract of the columns that are judged: the same verdicts, and none out of a file that does not fit."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from rvjax.analysis.verdicts import account_and_verdicts, judge_folder
from rvjax.errors import FolderError
from rvjax.report import build
from rvjax.run_folder import RunFolder
from rvjax.run_folder.verdict_columns import NAME, Extract
from tests.report.conftest import make


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with its report."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr("rvjax.report.sections.SECTIONS", ())
        folder = make(tmp_path_factory.mktemp("extract") / "run", 300, kept=0)
        build(folder)
    return folder


@pytest.fixture
def folder(reported: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    shutil.copytree(reported, tmp_path / "run")
    return tmp_path / "run"


def without(folder: Path) -> tuple[str, ...]:
    """The verdicts by the chunks alone."""
    (folder / NAME).unlink()
    return tuple(verdict.text for verdict in judge_folder(folder))


def used(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Notes whether judging reads the columns of the chunks."""
    read: list[bool] = []
    some = RunFolder.some
    monkeypatch.setattr(RunFolder, "some", lambda *given: read.append(True) or some(*given))
    return read


def test_it_gives_the_verdicts_of_the_chunks(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: an extract that is not used, samples in another order, outcomes mixed up."""
    read = used(monkeypatch)
    account, verdicts = account_and_verdicts(folder)
    assert not read
    assert account == RunFolder.open(folder).account()
    assert tuple(verdict.text for verdict in verdicts) == without(folder)
    assert read


@pytest.mark.parametrize("harm", ["damaged", "of other chunks", "without a column"])
def test_one_that_does_not_fit_is_not_used(folder: Path, harm: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: believing a file by its name; verdicts on a metric that it does not have."""
    expected = without(shutil.copytree(folder, folder.with_name("copy")))
    opened = RunFolder.open(folder)
    if harm == "damaged":
        data = bytearray((folder / NAME).read_bytes())
        data[len(data) // 2] ^= 1
        (folder / NAME).write_bytes(data)
    else:
        made = Extract()
        names = ["metric.settling_time_s"] if harm == "of other chunks" else []
        for chunk, frame, _ in opened.tables():
            made.add(chunk, frame.assign(outcome="captured"), names)
        chunks = replace(opened.chunks, sha256=0 * opened.chunks.sha256) if names else opened.chunks
        data = made.encoded(chunks)
        assert data is not None
        with opened:
            opened.write_bytes(NAME, data)
            opened.seal()
    read = used(monkeypatch)
    assert tuple(verdict.text for verdict in judge_folder(folder)) == expected
    assert read


def test_chunks_are_verified_all_the_same(folder: Path) -> None:
    """Kills: a verdict on samples whose files have changed since."""
    chunk = folder / RunFolder.open(folder).chunks[0].file
    data = bytearray(chunk.read_bytes())
    data[len(data) // 2] ^= 1
    chunk.write_bytes(data)
    with pytest.raises(FolderError, match="damaged or edited"):
        judge_folder(folder)


def test_a_report_made_again_has_the_same_extract(folder: Path) -> None:
    """Kills: bytes that depend on the order in which chunks came."""
    before = (folder / NAME).read_bytes()
    (folder / NAME).unlink()
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr("rvjax.report.sections.SECTIONS", ())
        build(folder)
    assert (folder / NAME).read_bytes() == before
