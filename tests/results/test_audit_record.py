"""What was audited before the first flight stays in the run folder."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rvjax.errors import FolderError
from rvjax.run_folder import Audited, RunFolder, atomic_files
from rvjax.run_folder.journal import _line
from rvjax.run_folder.manifest import Document, _seal

from .conftest import create, fly, resume

ONE = Audited(dispersions=2, read_back=3, acting=1, idle={"actuators.lower.tz": 208}, moved={"pursuer.mass_kg": "motion.nu.x"})
OTHER = Audited(dispersions=1, read_back=1, acting=1, idle={}, moved={"pursuer.mass_kg": "motion.nu.y"})


def rewritten(path: Path, change: tuple[str, str]) -> None:
    """Manifest and journal as another program would have written them."""
    text = (path / "manifest.json").read_text()
    body = text[: -len(_seal(b""))]
    assert body.count(change[0]) == 1
    body = body.replace(*change)
    data = body.encode() + _seal(body.encode())
    head = {name: value for name, value in json.loads(data).items() if name not in ("files", "sha256")}
    (path / "manifest.json").write_bytes(data)
    (path / "journal.jsonl").write_bytes(_line({"base": atomic_files.sha256(data), "head": head}))


def test_it_is_there_at_once_and_stays(tmp_path: Path) -> None:
    """Kills: a record that a killed run loses, that going on with a folder or making its manifest again forgets, or that makes
    another run of it."""
    path = tmp_path / "run"
    folder = create(path)
    before = folder.digest
    assert folder.audit is None
    folder.keep_audit(ONE)
    assert RunFolder.open(path).audit == ONE
    assert RunFolder.open(path).digest == before
    with folder:
        fly(folder)
    with resume(path, 12, text="rvjax: 1\nrequire: []\n") as again:
        assert again.audit == ONE
    for name in ("manifest.json", "journal.jsonl"):
        (path / name).write_bytes(b"{")
        with RunFolder.rebuild(path) as made:
            assert made.audit == ONE
    with resume(path, 12) as again:
        again.keep_audit(OTHER)
    assert RunFolder.open(path).audit == OTHER
    RunFolder.open(path).verify()


def test_the_same_once_more_writes_nothing(tmp_path: Path) -> None:
    """Kills: two more files to write at each going on."""
    path = tmp_path / "run"
    with create(path) as folder:
        folder.keep_audit(ONE)
    before = (path / "manifest.json").stat().st_ino
    with RunFolder.open(path) as folder:
        folder.keep_audit(ONE.model_copy())
    assert (path / "manifest.json").stat().st_ino == before


def test_a_folder_without_a_record_is_open_and_gets_one(finished: Path) -> None:
    """Kills: folders from before that nobody can read any more."""
    rewritten(finished, (' "audit": null,\n', ""))
    assert RunFolder.open(finished).audit is None
    RunFolder.open(finished).verify()
    with resume(finished, 10) as folder:
        assert folder.missing(3) == []
        folder.keep_audit(ONE)
    assert RunFolder.open(finished).audit == ONE


@pytest.mark.parametrize(
    "change",
    [
        ('"acting": 1', '"acting": 2'),
        ('"dispersions": 2,\n  "read_back": 3,\n  "acting": 1', '"dispersions": 3,\n  "read_back": 3,\n  "acting": 2'),
        ('"pursuer.mass_kg": ', '"actuators.lower.tz": '),
        ('"read_back": 3', '"read_back": -3'),
    ],
)
def test_a_record_that_does_not_add_up_is_none(tmp_path: Path, change: tuple[str, str]) -> None:
    """Kills: numbers that are believed because somebody wrote them."""
    path = tmp_path / "run"
    with create(path) as folder:
        folder.keep_audit(ONE)
    rewritten(path, change)
    with pytest.raises(FolderError, match="not a manifest"):
        Document.decode(path / "manifest.json", (path / "manifest.json").read_bytes())


def test_it_reads_as_a_sentence() -> None:
    assert str(ONE) == (
        "Before the first flight 2 dispersions were audited: 3 drawn columns were read back inside the compiled program, bit for "
        "bit or by an independent formula, and 1 acted when moved alone; without an effect, as audit.allow permits: "
        "actuators.lower.tz."
    )
    assert str(OTHER).startswith("Before the first flight 1 dispersion was audited: 1 drawn column was read back inside")
    assert "without" not in str(OTHER)
    nothing = Audited(dispersions=0, read_back=0, acting=0, idle={}, moved={})
    assert str(nothing) == "Nothing is drawn: there was no dispersion to audit."
