"""Where the time of a run goes, by phases."""

from __future__ import annotations

import json
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest

from rvjax import timings
from rvjax.execution.executors.threads import map_in_threads
from rvjax.report import build
from rvjax.timings import phase
from tests.program import Run
from tests.short import CAMPAIGN, QUICK, SHORT

SETS = [word for value in (*SHORT, QUICK, "keep={worst: 1}") for word in ("--set", value)]


class Clock:
    """A clock that goes only when it is told."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """The clock of the timings, which begin anew."""
    clock = Clock()
    monkeypatch.setattr(timings.time, "monotonic", clock.monotonic)
    monkeypatch.setattr(timings, "_IMPORTED", clock.now)
    monkeypatch.setattr(timings, "_before", lambda: 0.5)
    for name in ("_main", "_threads"):
        monkeypatch.setattr(timings, name, type(timings._main)(float))
    return clock


def test_a_phase_does_not_count_the_phases_inside_it(clock: Clock) -> None:
    """Kills: an inner phase that counts twice, a phase that counts only its last block, imports without what came before."""
    for _ in range(2):
        with phase("report"):
            clock.now += 1.0
            with phase("figures"):
                clock.now += 2.0
                with phase("imports"):
                    clock.now += 4.0
            clock.now += 8.0
    clock.now += 16.0
    measured = timings.timings()
    assert measured.main == {"imports": 8.5, "figures": 4.0, "report": 18.0}
    assert (measured.total, measured.other) == (46.5, 16.0)


def test_other_threads_are_counted_apart(clock: Clock) -> None:
    """Kills: the time of a thread in the sum of the main thread; a phase of a thread inside the phase of another thread."""

    def fly() -> None:
        with phase("fly"):
            clock.now += 3.0

    with phase("fly"):
        thread = threading.Thread(target=fly)
        thread.start()
        thread.join()
    measured = timings.timings()
    assert measured.main == {"fly": 3.0, "imports": 0.5}
    assert measured.threads == {"fly": 3.0}
    assert measured.document() == {
        "total_s": 3.5,
        "main_thread_s": {"fly": 3.0, "imports": 0.5, "other": 0.0},
        "other_threads_s": {"fly": 3.0},
    }


def test_a_phase_that_fails_is_counted(clock: Clock) -> None:
    """Kills: an error that leaves its phase open, so that all later phases are inside it."""
    with suppress(ValueError), phase("load"):
        clock.now += 1.0
        raise ValueError
    with phase("fly"):
        clock.now += 2.0
    assert timings.timings().main == {"load": 1.0, "fly": 2.0, "imports": 0.5}


def test_phases_that_have_not_ended_count(clock: Clock) -> None:
    """Kills: timings inside a phase that lack it; an outer phase with the time of an inner phase that is open."""
    with phase("report"):
        clock.now += 1.0
        with phase("load"):
            clock.now += 2.0
        with phase("imports"):
            clock.now += 4.0
            with phase("figures"):
                clock.now += 8.0
                measured = timings.timings()
    assert measured.main == {"report": 1.0, "load": 2.0, "imports": 4.5, "figures": 8.0}
    assert measured.other == 0.0


def test_a_run_says_where_its_time_went(rvjax: Run, tmp_path: Path) -> None:
    """In a table, in `summary.json`, and in the report that is made again. Kills: a phase that nobody enters; timings that a
    rebuilt report loses; timings in a summary that nobody asked for."""
    code, _, err = rvjax("run", CAMPAIGN, "--out", tmp_path / "run", *SETS, "--timings")
    assert code == 3  # 40 samples decide nothing
    summary = (tmp_path / "run" / "summary.json").read_text(encoding="utf-8")
    recorded = json.loads(summary)["timings"]
    entered = {*recorded["main_thread_s"], *recorded["other_threads_s"]}
    assert entered >= {"imports", "load", "draw", "audit", "fly", "write", "kept traces", "fold", "figures", "report", "other"}
    assert recorded["total_s"] == pytest.approx(sum(recorded["main_thread_s"].values()), abs=0.05)
    assert all(name in err for name in (*entered, "total", "main thread", "other threads"))
    build(tmp_path / "run")
    assert (tmp_path / "run" / "summary.json").read_text(encoding="utf-8") == summary
    rvjax("run", CAMPAIGN, "--out", tmp_path / "again", *SETS, "--quiet")
    assert "timings" not in json.loads((tmp_path / "again" / "summary.json").read_text(encoding="utf-8"))


def test_the_first_item_may_fly_alone() -> None:
    """And the order stays. Kills: a first chunk that shares the cores with others, so that it ends late; results that are lost or
    change places."""
    events: list[tuple[str, int]] = []
    taken: list[int] = []

    def fly(item: int) -> int:
        events.append(("begins", item))
        time.sleep(0.01)
        events.append(("ends", item))
        return item

    map_in_threads(fly, range(9), taken.append, lambda: None, first_alone=True)
    assert events[:2] == [("begins", 0), ("ends", 0)]
    assert taken == [*range(9)]
