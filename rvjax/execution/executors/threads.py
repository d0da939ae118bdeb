"""Executor: the threads of this process, one for each core, on all of its devices."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from itertools import islice
from typing import TypeVar

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.execution.chunks import ChunkRunner
from rvjax.execution.executors import Take, look_at_nothing
from rvjax.run_folder import RunFolder
from rvjax.simulation.batch import streams

T = TypeVar("T")
R = TypeVar("R")


LOOK_S = 0.2
"""Seconds between two looks at the flights under way."""


def map_in_threads(
    fly: Callable[[T], R],
    items: Iterable[T],
    take: Callable[[R], None],
    stop: Callable[[], None],
    look: Callable[[], None] = look_at_nothing,
    first_alone: bool = False,
) -> None:
    """Calls `fly` with every item, several at a time, and `take` with each result, in the order of the items and in this thread.

    look: called several times a second while this thread waits. first_alone: the others begin when the first has ended. Memory
    holds a few results at a time. On an interrupt `stop` ends the flights, and `take` gets what was flown before.
    """
    todo, flying = iter(items), deque[Future[R]]()
    with ThreadPoolExecutor(streams()) as threads:

        def begin(most: int) -> None:
            flying.extend(threads.submit(fly, item) for item in islice(todo, most - len(flying)))

        try:
            begin(1 if first_alone else 2 * streams())
            while flying:
                while not wait([flying[0]], LOOK_S).done:
                    look()
                begin(2 * streams() + 1)
                take(flying.popleft().result())
        except BaseException:
            stop()
            threads.shutdown(wait=True, cancel_futures=True)
            for future in flying:
                if not future.cancelled() and future.exception() is None:
                    take(future.result())
            raise


class ThreadExecutor:
    """Flies chunks in the threads of this process, and adds chunks of a folder to totals in this thread."""

    def __init__(self, runner: ChunkRunner, folder: RunFolder) -> None:
        self._runner, self._folder = runner, folder

    def fly(self, chunks: Iterable[int], take: Take, look: Callable[[], None] = look_at_nothing) -> None:
        """As `Executor.fly`, in the order of the chunks. If a chunk can fly on all threads, the first does, so it ends soon."""
        flyer = self._runner.flyer
        map_in_threads(
            self._runner.fly_chunk, chunks, lambda result: take([result]), flyer.stop, look, first_alone=flyer.divides_chunks
        )

    def fold(self, chunks: Iterable[int], results: RunAccumulator, look: Callable[[], None] = look_at_nothing) -> None:
        """As `Executor.fold`."""
        for table in self._folder.read_valid_chunks(chunks):
            results.add(*table)
            look()


@contextmanager
def local_threads(runner: ChunkRunner, folder: RunFolder) -> Generator[ThreadExecutor, None, None]:
    """The default executor."""
    yield ThreadExecutor(runner, folder)
