"""Timings: where the time of a process goes, phase by phase.

`phase(name)` counts the wall time of a block, without the phases inside it. So the phases of the main thread and `other` add up
to the time since the process began. What other threads do meanwhile is counted apart.
"""

from __future__ import annotations

import os
import time
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from threading import Lock, current_thread, local, main_thread
from types import TracebackType
from typing import Any, Literal

Phase = Literal[
    "imports", "load", "trace", "compile", "draw", "audit", "fly", "write", "kept traces", "fold", "figures", "report"
]
"""imports: of Python, packages and modules. load: the campaign becomes a problem. trace: the equations become a program. compile:
the program becomes machine code. draw: of samples. audit: flights that prove that every input acts. fly: flights of the samples;
the main thread waits for them. write: files are encoded, written and read back. kept traces: flights whose histories are kept.
fold: samples are added to the totals and verdicts. figures: they are drawn. report: the page and `summary.json`."""

_IMPORTED = time.monotonic()


@dataclass(frozen=True)
class Timings:
    """Seconds. total: since the process began. main: of the phases of the main thread, in the order in which they ended first.
    threads: of the same phases in all other threads together."""

    total: float
    main: dict[str, float]
    threads: dict[str, float]

    @property
    def other(self) -> float:
        """Seconds of the main thread outside of all phases."""
        return self.total - sum(self.main.values())

    def document(self) -> dict[str, Any]:
        """As plain JSON, rounded to milliseconds."""
        main, threads = ({name: round(x, 3) for name, x in part.items()} for part in (self.main, self.threads))
        main["other"] = round(self.other, 3)
        return {"total_s": round(self.total, 3), "main_thread_s": main, "other_threads_s": threads}


class _Stack(local):
    """The phases that a thread is in, the innermost last."""

    def __init__(self) -> None:
        self.phases: list[phase] = []


_stack = _Stack()
_main, _threads = defaultdict[str, float](float), defaultdict[str, float](float)
_counting = Lock()


class phase:
    """Counts the wall time of a block as a phase of its thread, without the phases inside it."""

    def __init__(self, name: Phase) -> None:
        self.name: Phase = name
        self.began = self.inside = 0.0

    def __enter__(self) -> None:
        self.began = time.monotonic()
        _stack.phases.append(self)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        whole = time.monotonic() - self.began
        _stack.phases.pop()
        if _stack.phases:
            _stack.phases[-1].inside += whole
        with _counting:
            (_main if current_thread() is main_thread() else _threads)[self.name] += whole - self.inside


def timings() -> Timings:
    """The timings of this process up to now. What came before this module was imported counts as imports."""
    before, now = _before(), time.monotonic()
    with _counting:
        main, threads = defaultdict(float, _main), dict(_threads)
    main["imports"] += before
    inner = 0.0
    for part in reversed(_stack.phases if current_thread() is main_thread() else []):  # phases that have not ended
        main[part.name] += now - part.began - part.inside - inner
        inner = now - part.began
    return Timings(now - _IMPORTED + before, dict(main), threads)


def _before() -> float:
    """Seconds between the begin of the process and the import of this module, to 10 ms; 0 where the system does not tell."""
    try:
        began = int(Path("/proc/self/stat").read_text(encoding="ascii").rpartition(")")[2].split()[19]) / os.sysconf("SC_CLK_TCK")
        since = time.clock_gettime(time.CLOCK_BOOTTIME) - began
    except (OSError, ValueError, AttributeError):
        return 0.0
    return max(0.0, since - (time.monotonic() - _IMPORTED))
