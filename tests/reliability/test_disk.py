"""The program on a disk that is full, fails, or refuses: what was flown is kept, and the message says what to do."""

from __future__ import annotations

import errno
import os
import shutil
import subprocess
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from rvjax.execution import chunks, identity, replay
from rvjax.execution import run as running
from rvjax.execution.chunks import ChunkResult, ChunkRunner
from rvjax.execution.executors import Take
from rvjax.execution.executors.threads import ThreadExecutor
from rvjax.run_folder import RunFolder
from rvjax.simulation import batch
from tests.disk import Disk, Killed
from tests.program import Run
from tests.reliability.nursery import Nursery
from tests.reliability.plain import PLAIN, proved
from tests.short import CAMPAIGN, SHORT

EVERY = {False: 37, True: 1}
"""One of so many calls fails, by whether the suite runs in its full numbers."""

WAYS = {errno.EIO: 4, errno.ENOSPC: 4, errno.EROFS: 5, None: None}
"""What a call may come to, and the exit code that it leads to; None: the process ends there."""

LANES = 16
"""Of the chunks here, which are flown once."""

SETS = [part for one in (*SHORT, *PLAIN, "keep={worst: 2}") for part in ("--set", one)]
DONE = 3
"""40 samples are too few for a verdict."""


def words(out: Path) -> list[object]:
    """The command."""
    return ["run", CAMPAIGN, "--quiet", "--out", out, *SETS]


def bits(path: Path) -> dict[str, bytes]:
    """All files but those that say when the run began, and what was set aside."""
    own = {"manifest.json", "journal.jsonl", "report.html", "report.md", "SHA256SUMS"}
    names = {file.relative_to(path).as_posix(): file for file in path.rglob("*") if file.is_file()}
    return {name: file.read_bytes() for name, file in names.items() if name not in own and "quarantine" not in file.parts}


@pytest.fixture
def canned(monkeypatch: pytest.MonkeyPatch) -> None:
    """The whole program but for flying and drawing: chunks and traces are flown once, the report is its numbers."""
    results: dict[int, ChunkResult] = {}
    traces: dict[tuple[int, ...], Any] = {}
    trace, fly = running.trace, running.fly

    class Canned:
        def __init__(self, runner: ChunkRunner, folder: RunFolder) -> None:
            self.runner, self.fold = runner, ThreadExecutor(runner, folder).fold

        def fly(self, chunks: Iterable[int], take: Take, look: Callable[[], None]) -> None:
            del look
            for chunk in chunks:
                if chunk not in results:
                    results[chunk] = self.runner.fly_chunk(chunk)
                take([results[chunk]])

    @contextmanager
    def executor(runner: ChunkRunner, folder: RunFolder) -> Iterator[Canned]:
        yield Canned(runner, folder)

    def once(problem: Any, flyer: Any, samples: list[int], *more: Any) -> Any:
        if tuple(samples) not in traces:
            traces[tuple(samples)] = trace(problem, flyer, samples, *more)
        return traces[tuple(samples)]

    for module in (batch, chunks, identity, replay, running):
        monkeypatch.setattr(module, "LANES", LANES)
    monkeypatch.setattr(running, "trace", once)
    monkeypatch.setattr(running, "prove", proved)
    monkeypatch.setattr(running, "fly", lambda *given: fly(*given[:3], replace(given[3], executor=executor)))
    monkeypatch.setattr("rvjax.report.sections.SECTIONS", ())


@pytest.mark.usefixtures("canned")
@pytest.mark.parametrize("error", WAYS)
def test_any_failing_call_of_a_run(
    error: int | None, tmp_path: Path, rvjax: Run, full: bool, figure: Callable[[str], None]
) -> None:
    """One call after the other fails, from the folder's creation to the report; then the same command is given again.

    Kills: a traceback; a failing disk that is a mistake of the program, a damaged folder or success; a report that is half old
    and half new and passes for whole; a run that cannot go on.
    """
    assert rvjax(*words(tmp_path / "whole"))[0] == DONE
    whole = bits(tmp_path / "whole")
    fails, hits = 1 + list(WAYS).index(error) * EVERY[full] // len(WAYS), 0
    while True:
        path = tmp_path / f"{fails}"
        with pytest.MonkeyPatch.context() as monkeypatch:
            disk = Disk(monkeypatch, path, fails, error)
            try:
                code, out, err = rvjax(*words(path))
            except Killed:
                code, out, err = None, "", ""
        if disk.calls < fails:
            break
        hits += 1
        assert code == WAYS[error], f"call {fails}, {disk.where}: {out}{err}"
        if error is not None:
            assert os.strerror(error) in err
            assert "give" in err, "it says what to do"
            assert "Traceback" not in err
        assert rvjax(*words(path))[0] == DONE, f"call {fails}, {disk.where}"
        assert bits(path) == whole, f"call {fails}, {disk.where}"
        RunFolder.open(path).verify()
        shutil.rmtree(path)
        fails += EVERY[full]
    assert hits > 3
    way = errno.errorcode[error] if error else "the end of the process"
    figure(f"failing calls of the program: {way} at {hits} of {disk.calls} calls from creation to report, then the same bits")


@pytest.fixture
def mounted(tmp_path: Path) -> Iterator[Nursery]:
    """A nursery with a file system of 8 MB at `tmp_path / "small"` and one that is read-only at `tmp_path / "fixed"`, which it
    alone sees and which vanish with it."""
    small, fixed = tmp_path / "small", tmp_path / "fixed"
    small.mkdir()
    fixed.mkdir()
    before = ["unshare", "-m"] if os.getuid() == 0 else ["unshare", "-rm"]
    mount = f"mount -t tmpfs -o size=8m none '{small}' && mount -t tmpfs -o ro none '{fixed}'"
    allowed = shutil.which("unshare") and subprocess.run([*before, "sh", "-c", mount], capture_output=True, check=False)
    if not allowed or allowed.returncode:
        pytest.skip("file systems cannot be mounted here")
    nursery = Nursery([*before, "sh", "-c", f'{mount} && exec "$@"', "sh"])
    yield nursery
    nursery.close()


def test_a_full_disk(mounted: Nursery, tmp_path: Path, figure: Callable[[str], None]) -> None:
    """A real one, with a little more room each time. Kills: a run that is lost with the space; half a file that is believed; a
    report that passes for whole.
    """
    log, path = tmp_path / "log", tmp_path / "small" / "run"
    whole = mounted.raise_child(words(tmp_path / "whole"), log)
    assert whole["code"] == DONE, log.read_text()
    disk = mounted.root() / str(tmp_path / "small").lstrip("/")
    ballast = disk / "ballast"
    kept: list[str] = []
    sizes = {file: -(-file.stat().st_size // 4096) * 4096 for file in (tmp_path / "whole").rglob("*") if file.is_file()}
    flown = sum(size for file, size in sizes.items() if file.suffix == ".parquet") // 1000
    report = sum(sizes.values()) // 1000 - flown
    for room in (0, flown // 2, flown + report // 2):  # KB for the whole run
        blocks = os.statvfs(disk)
        size = blocks.f_blocks * blocks.f_frsize - room * 1000
        with ballast.open("wb") as file:
            file.write(bytes(max(0, size)))
        log.unlink()
        answer = mounted.raise_child(words(path), log)
        said = log.read_text()
        assert answer["code"] == 4, said
        assert f"{os.strerror(errno.ENOSPC)}; free some space and give the same command again" in said
        assert "Traceback" not in said
        kept.append(answer["at"])
    assert {"open", "take", "write"} <= set(kept)
    ballast.unlink()
    answer = mounted.raise_child(words(path), log)
    assert answer["code"] == DONE, log.read_text()
    assert bits(disk / "run") == bits(tmp_path / "whole")
    RunFolder.open(disk / "run").verify()
    figure(f"disk full (tmpfs): {len(kept)} times, at {', '.join(kept)}; exit 4 each time, the same bits once there was room")


def test_a_read_only_disk(mounted: Nursery, tmp_path: Path, figure: Callable[[str], None]) -> None:
    """A real one. Kills: a traceback, an error that comes after flying."""
    log = tmp_path / "log"
    answer = mounted.raise_child(words(tmp_path / "fixed" / "run"), log)
    said = log.read_text()
    assert (answer["code"], answer["flown"]) == (2, []), said
    assert f"{os.strerror(errno.EROFS)}; accepted: a folder that can be written" in said
    assert "Traceback" not in said
    figure("read-only disk (tmpfs): exit 2, before anything was flown")


@pytest.mark.usefixtures("canned")
def test_places_that_are_no_place_for_a_run(tmp_path: Path, rvjax: Run, figure: Callable[[str], None]) -> None:
    """Another campaign's folder, a file, a folder with something else in it, one that nobody may write. Kills: flying into a
    folder that is not the run's own, a refusal that does not say in what it differs, a traceback.
    """
    path = tmp_path / "run"
    assert rvjax(*words(path))[0] == DONE
    before = {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}
    (tmp_path / "file").write_text("x")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "diary.txt").write_text("x")
    cases = (
        (path, 5, ["--set", "horizon.step_s=0.1"], ["belongs to another run", "campaign: the folder has"]),
        (path, 5, ["--seed", "7"], ["belongs to another run", "seed: the folder has 20181, this run has 7"]),
        (tmp_path / "file", 2, [], [os.strerror(errno.ENOTDIR), "accepted: a folder that can be written"]),
        (tmp_path / "file" / "below", 2, [], ["file is not a folder", "accepted: a folder that can be written"]),
        (tmp_path / "full", 5, [], ["there already and not empty; resume it, or choose another folder with --out"]),
    )
    for place, expected, more, parts in cases:
        code, out, err = rvjax(*words(place), *more)
        assert (code, out) == (expected, ""), err
        assert all(part in err for part in (str(place), *parts)), err
        assert "Traceback" not in err
    with pytest.MonkeyPatch.context() as monkeypatch:
        Disk(monkeypatch, tmp_path / "denied", 1, errno.EACCES)
        code, _, err = rvjax(*words(tmp_path / "denied"))
    assert code == 5
    assert f"{os.strerror(errno.EACCES)}; give yourself access to it" in err
    assert {file: file.read_bytes() for file in path.rglob("*") if file.is_file()} == before
    assert (tmp_path / "file").read_text() == (tmp_path / "full" / "diary.txt").read_text() == "x"
    figure(f"wrong places for a run: {len(cases) + 1}, exit 2 or 5, nothing in them changed")
