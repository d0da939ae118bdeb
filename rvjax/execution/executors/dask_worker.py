"""State of a Dask worker that flies a campaign's chunks, and the tasks it does: one for each worker process and campaign.

Every worker gets it, also a worker that connects later. The first task prepares it in a thread of the worker, before JAX starts
there. A worker that would fly other bits than the client (other versions, code, processor or settings) reports that and does
not fly. A worker that sees the run folder accumulates the totals of the chunks that it flies, until the client collects them.
"""

from __future__ import annotations

import signal
import tempfile
import time
import uuid
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any, cast

import pyarrow as pa
from distributed import Worker, WorkerPlugin, get_worker

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.components.samplers import sampling_design_of
from rvjax.errors import DamagedError, FolderError, RvjaxError
from rvjax.execution.chunks import ChunkResult, ChunkRunner, Segment
from rvjax.execution.identity import identity, packages
from rvjax.run_folder import CAMPAIGN, input_files
from rvjax.run_folder.local_storage import LocalStorage
from rvjax.run_folder.manifest import differences
from rvjax.run_folder.parquet import decode
from rvjax.run_folder.store import compared
from rvjax.simulation import jax_config
from rvjax.simulation.problem import load


@dataclass(frozen=True)
class WorkOrder:
    """What a worker flies, as text and numbers. inputs: the files that the campaign names. folder: the run folder's path at the
    client. token: name of a file in it; a worker that sees this file has the folder at the same path. local: the workers are
    child processes of the client."""

    campaign: str
    inputs: Mapping[str, bytes]
    overrides: tuple[str, ...]
    identity: Mapping[str, Any]
    packages: Mapping[str, str]
    folder: str
    token: str
    local: bool


@dataclass(frozen=True)
class Unlike:
    """A worker that would fly other bits: its address and the reason."""

    worker: str
    why: str


@dataclass(frozen=True)
class Failed:
    """A chunk whose flight raised an error, and its message; the exception itself cannot always be sent to the client."""

    chunk: int
    why: str


@dataclass(frozen=True)
class TaskResult:
    """What became of the chunks of a task, and the seconds that it took."""

    flown: tuple[ChunkResult, ...]
    failed: tuple[Failed, ...]
    seconds: float


class DaskWorkerState(WorkerPlugin):
    """Worker plugin; `name` identifies the campaign at the scheduler."""

    def __init__(self, order: WorkOrder) -> None:
        self.order = order
        self.name = f"rvjax{order.token}"

    def setup(self, worker: Worker) -> None:
        """Called at the worker when the plugin arrives."""
        if self.order.local:  # the client handles Ctrl-C and ends its workers
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        self._address, self._threads = str(worker.address), worker.state.nthreads
        self._making = Lock()
        self._runner: ChunkRunner | Unlike | None = None
        self._adding = Lock()
        self._segment = Segment(self._address, "")
        self._totals: RunAccumulator | None = None

    def teardown(self, worker: Worker) -> None:
        """Called at the worker when the campaign is over: ends flights whose results are not needed any more."""
        del worker
        if isinstance(self._runner, ChunkRunner):
            self._runner.flyer.stop()

    def runner(self) -> ChunkRunner | Unlike:
        """The chunk runner of this process, made at the first call; or why there is none."""
        with self._making:
            if self._runner is None:
                try:
                    self._runner = self._make()
                except Exception as error:  # noqa: BLE001
                    self._runner = Unlike(self._address, f"{type(error).__name__}: {error}")
            return self._runner

    def _make(self) -> ChunkRunner | Unlike:
        order = self.order
        with tempfile.TemporaryDirectory() as place:
            path = Path(place) / CAMPAIGN
            path.write_bytes(order.campaign.encode())
            input_files.write(LocalStorage(Path(place)), order.inputs)
            problem = load(path, order.overrides)
        jax_config.configure(problem.spec.precision, self._threads)
        worker_identity = identity(problem)
        unlike = differences(order.identity, worker_identity, "the client", "the worker")
        unlike += differences({"packages": order.packages}, {"packages": packages()}, "the client", "the worker")
        return Unlike(self._address, "\n".join(unlike)) if unlike else ChunkRunner(problem, worker_identity, self._threads)

    def fly(self, chunk: int) -> ChunkResult | Unlike:
        """Flies a chunk. Writes its files into the run folder where this worker sees it, and adds the samples to its totals; else
        the files are sent."""
        runner = self.runner()
        if isinstance(runner, Unlike):
            return runner
        if jax_config.precision() != runner.problem.spec.precision:
            return Unlike(self._address, f"another campaign flies there in {jax_config.precision()}")
        result = runner.fly_chunk(chunk)
        folder = self.folder()
        if folder is None:
            return result
        storage = LocalStorage(folder)
        published = tuple(file.put(storage) for file in result.files)  # compares the files with these bytes
        data = result.files[-1].data
        return ChunkResult(chunk, published, None if data is None else self._add(chunk, data))

    def folder(self) -> Path | None:
        """The run folder; None where this worker does not see it."""
        folder = Path(self.order.folder)
        return folder if (folder / self.order.token).is_file() else None

    def no_totals(self) -> RunAccumulator:
        """Totals without any chunk."""
        runner = self.runner()
        assert isinstance(runner, ChunkRunner)
        spec = runner.problem.spec
        return RunAccumulator(spec.require, sampling_design_of(spec), spec.keep)

    def _add(self, chunk: int, data: bytes) -> Segment | None:
        """Adds the samples table of a chunk to the totals here. None where they do not fit: the client then reads the file, and
        says why."""
        table = decode(data)
        with self._adding:
            if self._totals is None:
                self._totals, self._segment = self.no_totals(), Segment(self._address, uuid.uuid4().hex)
            if chunk in self._totals:  # flown again, since its first result was lost
                return self._segment
            try:
                self._totals.add(chunk, *table)
            except RvjaxError:
                self._totals = None  # part of the chunk may be in them
                return None
            return self._segment

    def hand_over(self, segment: str, chunks: Sequence[int]) -> bytes | None:
        """The totals of a segment, which begins a new one; None unless it is kept here and has just these chunks, ascending."""
        with self._adding:
            totals = self._totals
            if totals is None or segment != self._segment.name:
                return None
            self._totals = None
        return totals.encode() if list(totals.totals.chunks) == list(chunks) else None


def fly(name: str, chunks: Sequence[int]) -> TaskResult | Unlike:
    """Task: flies chunks."""
    began, flown, failed = time.monotonic(), list[ChunkResult](), list[Failed]()
    for chunk in chunks:
        try:
            outcome = _state(name).fly(chunk)
        except Exception as error:  # noqa: BLE001
            failed.append(Failed(chunk, f"{type(error).__name__}: {error}"))
            continue
        if isinstance(outcome, Unlike):
            return outcome
        flown.append(outcome)
    return TaskResult(tuple(flown), tuple(failed), time.monotonic() - began)


def ready(name: str) -> Unlike | None:
    """Task: does the worker fly the client's bits? None if it does."""
    runner = _state(name).runner()
    return runner if isinstance(runner, Unlike) else None


def hand_over(name: str, segment: str, chunks: Sequence[int]) -> bytes | None:
    """Task: the totals of a segment that this worker keeps; None where it does not, or where it has other chunks."""
    return _state(name).hand_over(segment, chunks)


def fold(name: str, files: Sequence[tuple[int, str, str]]) -> bytes | None:
    """Task: totals of committed chunks. files: their numbers, names and SHA-256.

    Damaged files are left out, and files that are not visible here. None where there are no totals then.
    """
    state = _state(name)
    folder = state.folder()
    if folder is None or isinstance(state.runner(), Unlike):
        return None
    totals = state.no_totals()
    for chunk, file, sha256 in files:
        with suppress(DamagedError, pa.ArrowException, OSError):
            totals.add(chunk, *decode(compared(LocalStorage(folder), file, sha256)))
    return totals.encode() if totals.totals.n else None


def merge(name: str, *parts: bytes | None) -> bytes | None:
    """Task: totals of several totals. A part that shares a chunk with one before it is left out, and so is one that is damaged;
    the client sees which chunks are missing. None where there are no totals."""
    present = [part for part in parts if part is not None]
    if len(present) < 2:
        return present[0] if present else None
    empty = _state(name).no_totals()
    totals = empty.decoded(present[0])
    for part in present[1:]:
        with suppress(FolderError):
            totals.merge(empty.decoded(part))
    return totals.encode()


def _state(name: str) -> DaskWorkerState:
    return cast("DaskWorkerState", get_worker().plugins[name])
