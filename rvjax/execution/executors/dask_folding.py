"""Folding: collects the totals that Dask workers have accumulated, so that the client reads no table.

Each worker process accumulates what it flies in a segment. The client notes which chunks are in which segment. To collect,
the workers hand over their segments, others merge them in a tree, and the client gets the root. Chunks that are not in it are
added from their files, by workers too: those of an earlier run, of a worker that died, and of a segment that has other chunks
than the client has noted. What no worker can read, since it is damaged or no worker sees the folder, the client reads.
"""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (Dask says little about its types)

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from queue import Empty, Queue

import numpy as np
from distributed import Client, Future

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.errors import FolderError, IncompleteError
from rvjax.execution.chunks import ChunkResult, Segment
from rvjax.execution.executors.dask_connection import ANSWER_S
from rvjax.execution.executors.dask_worker import fold, hand_over, merge
from rvjax.execution.executors.waiting import LOOK_S, Say, within
from rvjax.run_folder import RunFolder

TOGETHER = 8
"""Totals that a task merges."""

MOST_FILES = 64
"""Files that a task adds to totals."""

STALL_S = 3600.0
"""How long merging may take."""


class Folding:
    """Where the flown chunks are accumulated, and how they are collected. name: of the campaign at the workers."""

    def __init__(self, client: Client, name: str, folder: RunFolder, say: Say) -> None:
        self._client, self._name, self._folder, self._say = client, name, folder, say
        self._segments: dict[Segment, list[int]] = {}

    def note(self, results: Iterable[ChunkResult]) -> None:
        """Notes the segments of committed chunks."""
        for result in results:
            if result.segment is not None:
                self._segments.setdefault(result.segment, []).append(result.chunk)

    def collect(
        self, chunks: Iterable[int], results: RunAccumulator, look: Callable[[], None], threads: Callable[[], int]
    ) -> None:
        """Adds committed chunks to the results; as `Executor.fold`. threads: counts the threads of all workers, and raises
        IncompleteError where there are none for too long."""
        left = set(chunks)
        segments, self._segments = self._segments, {}
        kept = {segment: sorted(numbers) for segment, numbers in segments.items() if left.issuperset(numbers)}
        self._add(self._hand_over(kept), results, look, threads)
        self._add(self._from_files([chunk for chunk in sorted(left) if chunk not in results], threads()), results, look, threads)
        left = {chunk for chunk in left if chunk not in results}
        for table in self._folder.read_valid_chunks(sorted(left)):
            results.add(*table)
            look()

    def _hand_over(self, segments: dict[Segment, list[int]]) -> list[Future]:
        """Tasks at the workers that keep these segments. Where such a worker is gone, another answers that it has nothing."""
        return [
            self._client.submit(
                hand_over, self._name, segment.name, chunks, workers=[segment.worker], allow_other_workers=True, pure=False
            )
            for segment, chunks in segments.items()
        ]

    def _from_files(self, chunks: Sequence[int], threads: int) -> list[Future]:
        """Tasks that add chunks from their files."""
        if len(chunks) > MOST_FILES:
            self._say(f"{len(chunks)} chunks are read by the Dask workers")
        finished = self._folder.chunks
        wanted = finished.those(np.isin(finished.number, chunks))
        files = [(entry.number, entry.file, entry.sha256) for entry in wanted]
        size = max(1, min(MOST_FILES, -(-len(files) // max(1, threads))))
        return [
            self._client.submit(fold, self._name, files[first : first + size], pure=False) for first in range(0, len(files), size)
        ]

    def _add(self, futures: list[Future], results: RunAccumulator, look: Callable[[], None], threads: Callable[[], int]) -> None:
        """Merges the totals of all tasks in a tree of tasks, and adds them to the results."""
        while len(futures) > 1:
            groups = [futures[first : first + TOGETHER] for first in range(0, len(futures), TOGETHER)]
            futures = [self._client.submit(merge, self._name, *group, pure=False) for group in groups]
        data = self._result(futures[0], look, threads) if futures else None
        if data is None:
            return
        try:
            results.merge(results.decoded(data))
        except FolderError as error:  # the chunks are read from their files, where the reason shows
            self._say(f"totals of Dask workers are left out: {error}")

    def _result(self, root: Future, look: Callable[[], None], threads: Callable[[], int]) -> bytes | None:
        """What a task gives; None where it failed."""
        ended = Queue[None]()
        end = time.monotonic() + STALL_S
        root.add_done_callback(lambda _: ended.put(None))
        while time.monotonic() < end:
            try:
                ended.get(timeout=LOOK_S)
            except Empty:
                threads()
                look()
                continue
            if root.status == "cancelled":
                raise IncompleteError("the Dask scheduler was lost: its tasks are gone")
            if root.status in ("pending", "lost"):  # its result was lost, it runs again
                root.add_done_callback(lambda _: ended.put(None))
                continue
            try:
                return within(ANSWER_S, root.result, "a Dask worker does not send its totals", self._say)
            except IncompleteError:
                raise
            except Exception as error:  # noqa: BLE001  # any error of a worker: the chunks are read from their files
                self._say(f"totals of Dask workers were lost: {type(error).__name__}: {error}")
                return None
        raise IncompleteError(
            f"the Dask workers have not merged their totals for {STALL_S:g} s; look at them, then give the same command again"
        )
