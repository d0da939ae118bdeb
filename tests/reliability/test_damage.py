"""Bytes that change on the disk of a finished run: noticed wherever they are, named, and made good again."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from rvjax import report
from rvjax.errors import FolderError
from rvjax.report import sections
from rvjax.report.sections import captured, verdicts
from rvjax.run_folder import RunFolder
from tests.program import Run
from tests.report.conftest import make
from tests.results.conftest import create, fly, lacking, resume

MUTATIONS = {False: 1_000, True: 100_000}
"""By whether the suite runs in its full numbers."""

SHOWN = (verdicts.section, captured.section)
"""Sections of the report: with all of them, most of a check would be sums of megabytes of figures."""

PARTS = 4
HEALED = {False: 30, True: 200}
MADE_AGAIN = {False: 10, True: 50}
NEAR = 64
"""Every fourth change is within so many bytes of a file's beginning or end."""


@dataclass(frozen=True)
class Damage:
    """kind: what has happened to the file; from byte `place` on, `found` is there in place of `good`."""

    kind: str
    path: Path
    place: int
    good: bytes
    found: bytes

    def put(self, data: bytes, size: int) -> None:
        """These bytes at the place, and a length for the file."""
        with self.path.open("r+b") as file:
            file.seek(self.place)
            file.write(data)
            file.truncate(size)

    def do(self) -> None:
        """Damages the file."""
        cut = self.place if self.kind == "cut short" else self.path.stat().st_size
        self.put(self.found, cut)

    def undo(self) -> None:
        """Puts the bytes back."""
        self.put(self.good, max(self.path.stat().st_size, self.place + len(self.good)))


def damage(path: Path, data: bytes, generator: np.random.Generator) -> Damage:
    """A change of a file that does change its bytes: one bit, the end, or a block of zeros."""
    size = len(data)
    kind = ("bit flipped", "cut short", "block zeroed")[generator.integers(3)]
    place = int(generator.integers(size))
    if generator.uniform() < 0.25:
        place = (place % NEAR if generator.uniform() < 0.5 else size - 1 - place % NEAR) % size
    if kind == "cut short":
        if generator.uniform() < 0.5 and 0 < (end := data.find(b"\n", place) + 1) < size:
            place = end  # of a line: the ones before it are as good as ever
        return Damage(kind, path, place, data[place:], b"")
    if kind == "bit flipped":
        return Damage(kind, path, place, data[place : place + 1], bytes([data[place] ^ 1 << int(generator.integers(8))]))
    good = data[place : place + int(np.exp(generator.uniform(0, np.log(size))))]
    return Damage(kind, path, place, good, bytes(len(good))) if any(good) else damage(path, data, generator)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Path:
    """A finished run with its report, of which a few sections have every kind of file; all of them in the full numbers."""
    path = make(tmp_path_factory.mktemp("whole") / "run")
    with pytest.MonkeyPatch.context() as monkeypatch:
        if not request.config.getoption("--long"):
            monkeypatch.setattr(sections, "SECTIONS", SHOWN)
        report.build(path)
    RunFolder.open(path).verify()
    return path


def complaint(folder: Path) -> str:
    """What `rvjax doctor` finds wrong with a run folder; empty where it finds nothing."""
    try:
        RunFolder.open(folder).verify()
    except FolderError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("part", range(PARTS))
def test_no_damage_is_silent(part: int, whole: Path, full: bool, figure: Callable[[str], None]) -> None:
    """Every file as often as any other. Kills: a file that nothing covers, a check of sizes alone, a list of sums, a manifest or
    a journal that does not cover itself, a file looked at up to the first that is wrong.
    """
    generator = np.random.default_rng([20181, part])
    paths = sorted(path for path in whole.rglob("*") if path.is_file())
    names = {"SHA256SUMS", "campaign.yaml", "journal.jsonl", "manifest.json", "report.html", "report.md", "summary.json"}
    assert {path.name for path in paths} > names
    assert {path.suffix for path in whole.glob("figures/*")} == {".svg"}
    assert {path.parent.name for path in paths} == {whole.name, "samples", "envelopes", "traces", "figures"}
    good = {path: path.read_bytes() for path in paths}
    kinds: Counter[str] = Counter()
    for number in range(MUTATIONS[full] // PARTS):
        path = paths[generator.integers(len(paths))]
        one = damage(path, good[path], generator)
        one.do()
        said = complaint(whole)
        one.undo()
        assert path.name in said, f"part {part}, number {number}: {one.kind} from byte {one.place} of {path.name}: {said!r}"
        kinds[one.kind] += 1
    assert all(path.read_bytes() == data for path, data in good.items())
    assert not complaint(whole)
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    figure(f"damage, part {part + 1} of {PARTS}: {kinds.total()} changes in {len(paths)} files, 0 silent ({counts})")


def test_damaged_data_are_set_aside_and_flown_again(tmp_path: Path, full: bool, figure: Callable[[str], None]) -> None:
    """One to three files at a time. Kills: a damaged file that stays, one that is removed instead of set aside, a whole one that
    is flown again, an entry that outlives its file.
    """
    path = tmp_path / "run"
    with create(path) as folder:
        fly(folder)
    good = {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}
    data = [file for file in good if file.suffix == ".parquet"]
    generator = np.random.default_rng(20181)
    for number in range(HEALED[full]):
        chosen = [data[i] for i in generator.choice(len(data), generator.integers(1, 4), replace=False)]
        for file in chosen:
            damage(file, good[file], generator).do()
        bad = {file.read_bytes() for file in chosen}
        lost = {int(file.name[:5]) for file in chosen if file.parent.name != "traces"}
        with resume(path, 10) as folder:
            assert lacking(folder) == sorted(lost), f"number {number}: {chosen}"
            fly(folder)
        aside = path / "quarantine"
        assert {file.read_bytes() for file in aside.iterdir()} == bad, f"number {number}: {chosen}"
        shutil.rmtree(aside)
        left = {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}
        assert left == good, f"number {number}: {chosen}"
    figure(f"damage healed: {HEALED[full]} times 1 to 3 damaged data files set aside and flown again, folders bit-identical")


@pytest.mark.parametrize("name", ["manifest.json", "journal.jsonl"])
def test_doctor_makes_manifest_and_journal_again(
    name: str, tmp_path: Path, full: bool, rvjax: Run, figure: Callable[[str], None]
) -> None:
    """`rvjax doctor DIR` with either of them damaged. Kills: a manifest that is found damaged and left so; one that is made again
    from less than the other one knows; a folder that needs the tool twice.
    """
    path = tmp_path / "run"
    with create(path) as folder:
        fly(folder)
    good = {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}
    generator = np.random.default_rng(20181)
    for number in range(MADE_AGAIN[full]):
        one = damage(path / name, good[path / name], generator)
        one.do()
        code, out, err = rvjax("doctor", path, "--json")
        assert code == 0, f"number {number}: {one}: {out}{err}"
        assert "rebuilt" in out
        shutil.rmtree(path / "quarantine")
        assert {file: file.read_bytes() for file in path.rglob("*") if file.is_file()} == good, f"number {number}: {one}"
    figure(f"damage healed: {MADE_AGAIN[full]} times {name} made again by `rvjax doctor`, bit-identical")
