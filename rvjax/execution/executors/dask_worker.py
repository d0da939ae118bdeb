"""DaskWorkerState: what a Dask worker flies a campaign's chunks with. One for each worker process and campaign.

It is sent to every worker, also to those that come later, and made ready in a worker's thread by the first task, before JAX
starts there. A worker that would fly other bits than the client (other versions, code, processor or settings) says so and flies
nothing.
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
from rvjax.run_folder import CAMPAIGN
from rvjax.run_folder import input_files as inputs
from rvjax.run_folder.manifest import differences
from rvjax.simulation import jax_config
from rvjax.simulation.problem import load


@dataclass(frozen=True)
class WorkOrder:
    """What is to be flown, as text and numbers. inputs: the files that the campaign names. folder: the run folder's path at the
    client; token: name of a file in it, by which a worker that has the folder at the same path recognises it. local: the workers
    are the client's own processes."""

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
    """A worker that flies nothing: its address, and why."""

    worker: str
    why: str


@dataclass(frozen=True)
class Failed:
    """A flight that raised an error, in words: an error itself may not survive its way to the client."""

    why: str


class DaskWorkerState(WorkerPlugin):
    """The plugin of a worker; `name` is the campaign's at the scheduler."""

    def __init__(self, order: WorkOrder) -> None:
        self.order = order
        self.name = f"rvjax{order.token}"

    def setup(self, worker: Worker) -> None:
        """Called at the worker when it gets the plugin."""
        if self.order.local:  # Ctrl-C in the terminal is the client's, which ends them
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        self._address, self._threads = str(worker.address), worker.state.nthreads
        self._making = Lock()
        self._pilot: ChunkRunner | Unlike | None = None

    def teardown(self, worker: Worker) -> None:
        """Called at the worker when the campaign is over: flights that nobody waits for end."""
        del worker
        if isinstance(self._pilot, ChunkRunner):
            self._pilot.flyer.stop()

    def pilot(self) -> ChunkRunner | Unlike:
        """The campaign's pilot in this process; made once."""
        with self._making:
            if self._pilot is None:
                try:
                    self._pilot = self._make()
                except Exception as error:  # noqa: BLE001
                    self._pilot = Unlike(self._address, f"{type(error).__name__}: {error}")
            return self._pilot

    def _make(self) -> ChunkRunner | Unlike:
        order = self.order
        with tempfile.TemporaryDirectory() as place:
            path = Path(place) / CAMPAIGN
            path.write_text(order.campaign)
            inputs.write(Path(place), order.inputs)
            problem = load(path, order.overrides)
        jax_config.configure(problem.spec.precision, self._threads)
        mine = identity(problem)
        unlike = differences(order.identity, mine, "the client", "the worker")
        unlike += differences({"packages": order.packages}, {"packages": packages()}, "the client", "the worker")
        return Unlike(self._address, "\n".join(unlike)) if unlike else ChunkRunner(problem, mine)

    def fly(self, chunk: int) -> ChunkResult | Unlike:
        """Flies a chunk; its files are written into the run folder where this worker sees it, else they are sent."""
        pilot = self.pilot()
        if isinstance(pilot, Unlike):
            return pilot
        if jax_config.precision() != pilot.problem.spec.precision:
            return Unlike(self._address, f"another campaign flies there in {jax_config.precision()}")
        parcel = pilot.parcel(chunk)
        folder = Path(self.order.folder)
        if (folder / self.order.token).is_file():
            return parcel._replace(files=tuple(file.put(folder) for file in parcel.files))
        return parcel


def fly(name: str, chunk: int) -> ChunkResult | Unlike | Failed:
    """The task of a chunk."""
    try:
        return _station(name).fly(chunk)
    except Exception as error:  # noqa: BLE001
        return Failed(f"{type(error).__name__}: {error}")


def ready(name: str) -> Unlike | None:
    """The task by which a worker says whether it flies the client's bits."""
    pilot = _station(name).pilot()
    return pilot if isinstance(pilot, Unlike) else None


def _station(name: str) -> DaskWorkerState:
    return cast("DaskWorkerState", get_worker().plugins[name])
