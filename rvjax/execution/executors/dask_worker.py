"""State of a Dask worker that flies a campaign's chunks: one for each worker process and campaign.

Every worker gets it, also a worker that connects later. The first task prepares it in a thread of the worker, before JAX starts
there. A worker that would fly other bits than the client (other versions, code, processor or settings) reports that and does
not fly.
"""

from __future__ import annotations

import signal
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any, cast

from distributed import Worker, WorkerPlugin, get_worker

from rvjax.execution.chunks import ChunkResult, ChunkRunner
from rvjax.execution.identity import identity, packages
from rvjax.run_folder import CAMPAIGN, input_files
from rvjax.run_folder.manifest import differences
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
    """The message of an error that a flight raised; the exception itself cannot always be sent to the client."""

    why: str


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
            input_files.write(Path(place), order.inputs)
            problem = load(path, order.overrides)
        jax_config.configure(problem.spec.precision, self._threads)
        worker_identity = identity(problem)
        unlike = differences(order.identity, worker_identity, "the client", "the worker")
        unlike += differences({"packages": order.packages}, {"packages": packages()}, "the client", "the worker")
        return Unlike(self._address, "\n".join(unlike)) if unlike else ChunkRunner(problem, worker_identity, self._threads)

    def fly(self, chunk: int) -> ChunkResult | Unlike:
        """Flies a chunk. Writes its files into the run folder where this worker sees it; else they are sent."""
        runner = self.runner()
        if isinstance(runner, Unlike):
            return runner
        if jax_config.precision() != runner.problem.spec.precision:
            return Unlike(self._address, f"another campaign flies there in {jax_config.precision()}")
        result = runner.fly_chunk(chunk)
        folder = Path(self.order.folder)
        if (folder / self.order.token).is_file():
            return result._replace(files=tuple(file.put(folder) for file in result.files))
        return result


def fly(name: str, chunk: int) -> ChunkResult | Unlike | Failed:
    """The task of a chunk."""
    try:
        return _state(name).fly(chunk)
    except Exception as error:  # noqa: BLE001
        return Failed(f"{type(error).__name__}: {error}")


def ready(name: str) -> Unlike | None:
    """Task: does the worker fly the client's bits? None if it does."""
    runner = _state(name).runner()
    return runner if isinstance(runner, Unlike) else None


def _state(name: str) -> DaskWorkerState:
    return cast("DaskWorkerState", get_worker().plugins[name])
