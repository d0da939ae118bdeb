"""Executors: what flies the chunks and folds their tables into totals. An executor may stop at any time: the run folder holds
what is done."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager
from typing import Protocol

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.execution.chunks import ChunkResult, ChunkRunner
from rvjax.run_folder import RunFolder

Take = Callable[[Sequence[ChunkResult]], None]
"""Gets the results of chunks that arrived together."""


def look_at_nothing() -> None:
    """Does nothing: who waits tells nobody."""


class Executor(Protocol):
    """Flies chunks, hands over their results in any order, and adds committed chunks to totals."""

    def fly(self, chunks: Iterable[int], take: Take, look: Callable[[], None] = look_at_nothing) -> None:
        """Calls `take` with the results of all chunks, in this thread, while others fly, and `look` now and then while it waits.
        Memory holds a few results at a time. On an interrupt, what was flown is still handed over.

        IncompleteError names the chunks that could not be flown, after all others were handed over.
        """
        ...

    def fold(self, chunks: Iterable[int], results: RunAccumulator, look: Callable[[], None] = look_at_nothing) -> None:
        """Adds committed chunks to the results, those that were flown elsewhere and those of an earlier run. A damaged chunk is
        moved to `quarantine/` instead, and counts as missing from then on."""
        ...


ExecutorFactory = Callable[[ChunkRunner, RunFolder], AbstractContextManager[Executor]]
"""Gives an executor for a campaign that is flown into a folder; leaving the context releases it."""
