"""Executor: the threads of this process, one for each core, on all devices that it has."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from itertools import islice
from typing import TypeVar

from rvjax.execution.chunks import ChunkResult, ChunkRunner
from rvjax.run_folder import RunFolder
from rvjax.simulation.batch import streams

T = TypeVar("T")
R = TypeVar("R")


def map_in_threads(fly: Callable[[T], R], things: Iterable[T], take: Callable[[R], None], stop: Callable[[], None]) -> None:
    """Calls `fly` with every thing, several beside each other, and `take` with what comes of each, in their order and in this
    thread. Memory holds a few at a time. Where it is interrupted, `stop` ends what flies, and what has been flown is taken."""
    todo, flying = iter(things), deque[Future[R]]()
    with ThreadPoolExecutor(streams()) as threads:
        try:
            while True:
                flying.extend(threads.submit(fly, one) for one in islice(todo, 2 * streams() - len(flying)))
                if not flying:
                    break
                take(flying.popleft().result())
        except BaseException:
            stop()
            threads.shutdown(wait=True, cancel_futures=True)
            for future in flying:
                if not future.cancelled() and future.exception() is None:
                    take(future.result())
            raise


class Inline:
    """Flies chunks by the threads of this process."""

    def __init__(self, pilot: ChunkRunner) -> None:
        self._pilot = pilot

    def fly(self, chunks: Iterable[int], take: Callable[[ChunkResult], None]) -> None:
        """As `Executor.fly`, in the order of the chunks."""
        map_in_threads(self._pilot.parcel, chunks, take, self._pilot.flyer.stop)


@contextmanager
def inline(pilot: ChunkRunner, folder: RunFolder) -> Generator[Inline, None, None]:
    """The default crew."""
    del folder
    yield Inline(pilot)
