"""Progress of a run: its phases, and how far each of them is."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

Phase = Literal["audit", "flights", "rare failures", "traces", "report"]


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How far a phase of a run is.

    phase: audit, flights, rare failures (a search beside the samples), traces (the kept samples are flown again) or report.
    done, total: flights that have ended, and all of the phase; both 0 where a phase does not count flights. share: part of all
    steps of these flights that is flown, 0 to 1; the steps of flights under way count. seconds: time since the phase began.
    ended: whether this is the last call of the phase. note: the present estimate of a search.
    """

    phase: Phase
    done: int = 0
    total: int = 0
    share: float = 0.0
    seconds: float = 0.0
    ended: bool = False
    note: str = ""


OnProgress = Callable[[Progress], None]
"""Gets the progress of a run, in the thread that runs it: when a phase begins and ends, after each chunk of flights, and
several times a second while flights are under way."""


class PhaseProgress:
    """Reports the progress of a phase that flies."""

    def __init__(self, phase: Phase, on_progress: OnProgress, steps_flown: Callable[[], int], steps: int, lanes: int) -> None:
        """steps_flown: steps that chunks have flown in this process so far. steps: of a flight. lanes: flights of a chunk."""
        self._phase: Phase = phase
        self._on_progress = on_progress
        self._steps_flown, self._steps, self._lanes = steps_flown, steps, lanes
        self._started = time.monotonic()
        self._done = self._total = self._counted = 0

    def begin(self, done: int, total: int) -> None:
        """Chunks are about to fly, after which `total` flights have ended."""
        self._done, self._total, self._counted = done, total, self._steps_flown()
        self.look()

    def count(self, flights: int) -> None:
        """The flights of a chunk have ended."""
        self._done += flights
        self._counted += self._steps
        self.look()

    def look(self) -> None:
        """Reports how far the flights under way are; nothing before any begin."""
        if self._total:
            self._report(ended=False)

    def end(self) -> None:
        """The phase is over. A phase that flew nothing is not reported."""
        if self._total:
            self._report(ended=True)

    def _report(self, *, ended: bool) -> None:
        chunks = max(0.0, (self._steps_flown() - self._counted) / self._steps)  # other processes count no steps here
        left = self._total - self._done
        flown = self._done + left * min(1.0, chunks / max(1, math.ceil(left / self._lanes)))  # the last chunk may not be full
        self._on_progress(
            Progress(
                phase=self._phase,
                done=self._done,
                total=self._total,
                share=flown / self._total,
                seconds=time.monotonic() - self._started,
                ended=ended,
            )
        )


@contextmanager
def timed(phase: Phase, on_progress: OnProgress) -> Generator[None, None, None]:
    """Reports the begin and the end of a phase that counts no flights."""
    started = time.monotonic()
    on_progress(Progress(phase=phase))
    yield
    on_progress(Progress(phase=phase, share=1.0, seconds=time.monotonic() - started, ended=True))
