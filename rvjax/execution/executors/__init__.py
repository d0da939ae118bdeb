"""Executors: who flies the chunks. Whoever it is may die at any time; the run folder is what counts."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import Protocol

from rvjax.execution.chunks import ChunkResult, ChunkRunner
from rvjax.run_folder import RunFolder


class Executor(Protocol):
    """Flies chunks and hands over what came of them, in any order."""

    def fly(self, chunks: Iterable[int], take: Callable[[ChunkResult], None]) -> None:
        """Calls `take` with every chunk's parcel, in this thread, while others fly. Memory holds a few at a time. Where it is
        interrupted, what has been flown is still handed over.

        IncompleteError names the chunks that could not be flown, after all others were handed over.
        """
        ...


ExecutorFactory = Callable[[ChunkRunner, RunFolder], AbstractContextManager[Executor]]
"""How to get an executor for a pilot's campaign, flown into a folder; it is given up again on leaving the context."""
