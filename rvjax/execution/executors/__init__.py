"""Executors: what flies the chunks. An executor may stop at any time: the run folder holds what is done."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import Protocol

from rvjax.execution.chunks import ChunkResult, ChunkRunner
from rvjax.run_folder import RunFolder


class Executor(Protocol):
    """Flies chunks and hands over their results in any order."""

    def fly(self, chunks: Iterable[int], take: Callable[[ChunkResult], None], look: Callable[[], None] = lambda: None) -> None:
        """Calls `take` with the result of every chunk, in this thread, while others fly, and `look` now and then while it waits.
        Memory holds a few results at a time. On an interrupt, what was flown is still handed over.

        IncompleteError names the chunks that could not be flown, after all others were handed over.
        """
        ...


ExecutorFactory = Callable[[ChunkRunner, RunFolder], AbstractContextManager[Executor]]
"""Gives an executor for a campaign that is flown into a folder; leaving the context releases it."""
