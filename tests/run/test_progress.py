"""Progress of a run: phases with their times, steps within a chunk, and how it is shown."""

from __future__ import annotations

import io
import sys
import time
import types
from collections import OrderedDict
from pathlib import Path
from typing import Any

import pytest

from rvjax.errors import CampaignWarning
from rvjax.execution.progress import PhaseProgress, Progress
from rvjax.execution.progress_display import ProgressLines, lines
from rvjax.execution.run import run
from rvjax.simulation.engines.llvm.engine import LlvmChunk
from tests.short import CAMPAIGN, QUICK, SHORT

pytestmark = pytest.mark.usefixtures("bare")

ONE_CHUNK = (*SHORT, QUICK, "samples=4", "keep={worst: 2}")


def test_a_single_chunk_shows_its_steps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a run of up to 416 samples that goes from 0 to all; a phase without its begin, its end or its time; a share that
    goes back or exceeds 1; steps of the audit among those of the flights."""
    monkeypatch.setattr("rvjax.execution.executors.threads.LOOK_S", 0.002)
    advance = LlvmChunk.advance

    def slowly(self: LlvmChunk, first: int, last: int, threads: int = 1) -> None:
        advance(self, first, last, threads)
        time.sleep(0.002)

    monkeypatch.setattr(LlvmChunk, "advance", slowly)
    reports: list[Progress] = []
    run(CAMPAIGN, tmp_path / "run", [*ONE_CHUNK, "engine=llvm"], progress=reports.append)
    phases = list(dict.fromkeys(report.phase for report in reports))
    assert phases == ["audit", "flights", "traces", "report"]
    assert [report.phase for report in reports if report.ended] == phases
    for phase, total in (("flights", 4), ("traces", 2)):
        of = [report for report in reports if report.phase == phase]
        shares = [report.share for report in of]
        assert shares == sorted(shares)
        assert (shares[0], shares[-1]) == (0.0, 1.0)
        under_way = {report.share for report in of if report.done == 0}
        assert len(under_way) > 3, "seen within the chunk"
        assert {report.total for report in of} == {total}
        assert of[-1].done == total
        seconds = [report.seconds for report in of]
        assert seconds == sorted(seconds)
        assert seconds[-1] > 0.0

    again: list[Progress] = []
    run(CAMPAIGN, tmp_path / "run", [*ONE_CHUNK, "engine=llvm"], progress=again.append)
    assert [report.phase for report in again] == ["report", "report"], "nothing was flown"


def test_the_share_counts_steps_under_way() -> None:
    """Two chunks of 10 lanes and 100 steps after 5 of 22 flights: half a chunk is a quarter of the other 17. Then 7 are left in a
    chunk that is not full. Kills: steps counted twice; steps of another process missing; a chunk of a few flights that is over
    after a few steps."""
    flown = 1000
    reports: list[Progress] = []
    phase = PhaseProgress("flights", reports.append, lambda: flown, 100, 10)
    phase.end()
    assert reports == [], "a phase that flies nothing is not reported"
    phase.begin(5, 22)
    flown += 50
    phase.look()
    flown += 50
    phase.count(10)
    flown += 80
    phase.look()
    flown += 20
    phase.count(7)
    phase.end()
    shares = [report.share * 22 for report in reports]
    assert shares == pytest.approx([5, 5 + 17 / 4, 15, 15 + 0.8 * 7, 22, 22])
    assert [report.done for report in reports] == [5, 5, 15, 15, 22, 22]
    assert [report.ended for report in reports] == [False] * 5 + [True]

    reports.clear()
    elsewhere = PhaseProgress("flights", reports.append, lambda: 0, 100, 10)
    elsewhere.begin(0, 20)
    elsewhere.count(10)
    elsewhere.count(10)
    assert [report.share for report in reports] == [0.0, 0.5, 1.0]


def flights(done: int, share: float, seconds: float, *, ended: bool = False, total: int = 1000) -> Progress:
    return Progress(phase="flights", done=done, total=total, share=share, seconds=seconds, ended=ended)


def test_the_lines_of_a_log() -> None:
    """By hand: from 4 s and 10 % to 6 s and 30 %, 200 of 1,000 samples took 2 s, so 100 a second, and 700 take 7 s more. Kills:
    compile time in the speed; a line for each report; a phase without its time."""
    lines: list[str] = []
    show = ProgressLines(lines.append)
    show(Progress(phase="audit"))
    show(Progress(phase="audit", share=1.0, seconds=1.7, ended=True))
    for progress in (
        flights(0, 0.0, 0.0),
        flights(0, 0.0, 3.9),
        flights(0, 0.1, 4.0),
        flights(0, 0.2, 5.0),
        flights(0, 0.3, 6.0),
        flights(0, 0.4, 7.0),
        flights(416, 0.5, 10.1),
        flights(1000, 1.0, 15.0),
        flights(1000, 1.0, 15.04, ended=True),
    ):
        show(progress)
    show(flights(3, 0.5, 0.0, total=6))
    show(flights(6, 1.0, 0.1, total=6, ended=True))
    assert lines == [
        "auditing",
        "audit: 1.7 s",
        "flying 1,000 of 1,000 samples",
        "flights: 20 %, 0 of 1,000 samples",
        "flights: 50 %, 416 of 1,000 samples, 66 samples/s, 8 s left",
        "flights: 1,000 samples in 15.0 s",
        "flying 3 of 6 samples",
        "flights: 6 samples in 0.1 s",
    ]


def test_a_long_run_has_a_short_log(full: bool) -> None:
    """A week of looks, one a second, without `--long` every 5 s. Kills: a line every few seconds, 120,000 of them."""
    lines: list[str] = []
    show = ProgressLines(lines.append)
    week = 7 * 86400
    for second in range(0, week, 1 if full else 5):
        show(flights(second, second / week, float(second), total=week))
    assert 100 < len(lines) < 500


class Stream(io.StringIO):
    """stderr, of a terminal or not."""

    def __init__(self, *, terminal: bool) -> None:
        super().__init__()
        self._terminal = terminal

    def isatty(self) -> bool:
        return self._terminal


@pytest.mark.parametrize(("terminal", "progress", "shown"), [(True, True, True), (False, True, False), (True, False, False)])
def test_python_shows_it_in_a_terminal(
    terminal: bool, progress: bool, shown: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: a silent `fly_campaign`; control characters in a log; progress=False without an effect."""
    monkeypatch.setattr(sys, "stderr", stream := Stream(terminal=terminal))
    monkeypatch.setenv("TERM", "xterm")
    run(CAMPAIGN, tmp_path / "run", (*ONE_CHUNK, "horizon.step_s=0.2"), progress=progress)
    text = stream.getvalue()
    assert bool(text) is shown
    for phase in ("audit: ", "flights: 4 samples in ", "traces: 2 samples in ", "report: "):
        assert (phase in text) is shown


def notebook(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """A double of IPython in a notebook; what is shown in its cell: the updates of each line."""
    cell: list[list[str]] = []

    class Handle:
        def __init__(self, place: int) -> None:
            self._place = place

        def update(self, content: dict[str, str], *, raw: bool) -> None:
            assert raw
            cell[self._place].append(content["text/plain"])

    def show(content: dict[str, str], *, raw: bool, display_id: bool) -> Handle:
        assert raw
        assert display_id
        cell.append([content["text/plain"]])
        return Handle(len(cell) - 1)

    shell: Any = type("ZMQInteractiveShell", (), {})()
    ipython, display = types.ModuleType("IPython"), types.ModuleType("IPython.display")
    ipython.__dict__.update(get_ipython=lambda: shell, display=display)
    display.__dict__.update(display=show)
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.setattr(sys, "stderr", Stream(terminal=False))
    return cell


def test_python_shows_it_in_a_notebook(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a double of IPython: a line per phase, updated in place. Kills: a notebook without progress; a line per report."""
    cell = notebook(monkeypatch)
    monkeypatch.setattr("rvjax.execution.executors.threads.LOOK_S", 0.002)
    run(CAMPAIGN, tmp_path / "run", ONE_CHUNK)
    assert [updates[0] for updates in cell] == [
        "auditing",
        "flying 4 of 4 samples",
        "tracing 2 of 2 samples",
        "writing the report",
    ]
    assert [updates[-1].partition(":")[0] for updates in cell] == ["audit", "flights", "traces", "report"]
    assert any("%" in line for line in cell[1]), "the line of the flights moves"


def test_a_law_that_cannot_be_traced_leaves_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An error of any type in a user's law, met when JAX first traces it: with `xla` after the folder was made. Kills: a folder
    without a single flight."""

    def broken(*arguments: object) -> None:
        raise TypeError("not of this shape")

    monkeypatch.setattr("rvjax.simulation.engines.choice._choices", OrderedDict())
    monkeypatch.setattr("rvjax.components.controllers.pd_plus.respond", broken)
    with pytest.raises(TypeError, match="not of this shape"):
        run(CAMPAIGN, tmp_path / "new" / "run", [*ONE_CHUNK, "engine=xla"])
    assert list(tmp_path.iterdir()) == []


def test_python_warns_of_what_is_hardly_meant(tmp_path: Path) -> None:
    """Kills: a mass guess far from the plant that only the command line speaks of."""
    doubtful = "controller={use: pd-plus, gains: {mass_guess_kg: 250}}"
    with pytest.warns(CampaignWarning, match="mass_guess_kg"):
        run(CAMPAIGN, tmp_path / "run", (*SHORT, "samples=4", "keep={worst: 0}", doubtful), progress=False)


def test_a_search_shows_its_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    """One line that is updated in a notebook; nothing where progress is off, or without a terminal. Kills: a line for each batch
    in a notebook; a search without progress."""
    cell = notebook(monkeypatch)
    for progress in (True, False):
        with lines(progress) as say:
            say("416 of 20,000 flights")
            say("832 of 20,000 flights")
    assert cell == [["416 of 20,000 flights", "832 of 20,000 flights"]]
    monkeypatch.delitem(sys.modules, "IPython")
    with lines(True) as say:
        say("nobody")
    assert len(cell) == 1
