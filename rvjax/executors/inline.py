"""Executor: the threads of this process, one for each core, on all devices that it has."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager

from rvjax.batch import streams
from rvjax.pilot import Parcel, Pilot
from rvjax.results import RunFolder


class Inline:
    """Flies chunks by the threads of this process."""

    def __init__(self, pilot: Pilot) -> None:
        self._pilot = pilot

    def fly(self, chunks: Iterable[int], take: Callable[[Parcel], None]) -> None:
        """As `Executor.fly`, in the order of the chunks."""
        todo, flying = iter(chunks), deque[Future[Parcel]]()
        with ThreadPoolExecutor(streams()) as threads:
            try:
                while True:
                    while len(flying) < 2 * streams() and (chunk := next(todo, None)) is not None:
                        flying.append(threads.submit(self._pilot.parcel, chunk))
                    if not flying:
                        break
                    take(flying.popleft().result())
            except BaseException:
                self._pilot.flyer.stop()
                threads.shutdown(wait=True, cancel_futures=True)
                for future in flying:
                    if not future.cancelled() and future.exception() is None:
                        take(future.result())
                raise


@contextmanager
def inline(pilot: Pilot, folder: RunFolder) -> Generator[Inline, None, None]:
    """The default crew."""
    del folder
    yield Inline(pilot)
