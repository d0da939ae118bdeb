"""What Dask costs the client and the scheduler: `python -m benchmarks.dask_costs [--chunks 1000] [--workers 2]`.

Flights of a few steps, so that everything beside them shows. Processor time, not the clock, unless it says so:

    client      of this process, with the threads of Dask, from the first task to the last commit, for each chunk and each task
    commit      the part of it that reads the files back, compares them with their SHA-256 and writes the journal, for each chunk
    message     the answer of a task as Dask serialises it, where the task is one chunk
    scheduler   of its process, for each task, less what it takes while nothing is flown, in the same time
    worker      of its processes, for each chunk: a short flight, encoding, publishing, adding
    collect     of this process, and by the clock, until the client has the totals of all chunks
    from files  the same for the next process, which has to have all chunks read again

What came out: docs/cluster.md.
"""

from __future__ import annotations

import argparse
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

from distributed.protocol.serialize import serialize

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.components.samplers import sampling_design_of
from rvjax.execution.chunks import ChunkResult, ChunkRunner
from rvjax.execution.executors.dask_client import Workers, workers
from rvjax.execution.executors.dask_worker import TaskResult
from rvjax.execution.identity import identity, provenance
from rvjax.run_folder import RunDescription, RunFolder
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES
from rvjax.simulation.problem import Problem, load

CAMPAIGN = Path(__file__).parents[1] / "campaigns" / "quickstart.yaml"
SHORT = (
    "horizon={duration_s: 2, step_s: 0.05}",
    "capture={position_m: 100, attitude_mrp: 1, window_s: 1}",
    "faults.effectiveness.onset_s={uniform: [1, 2]}",
    "faults.bias.onset_s={uniform: [1, 2]}",
    "require=[{metric: captured, at_least: 0.95}, {metric: settling_time_s, quantile: 0.9, below: 200}]",
)

IDLE_S = 5.0
"""How long nothing is flown, to see what the scheduler takes then."""


class DaskCosts(NamedTuple):
    """What flying chunks with Dask took. client, committing, scheduling, flying: seconds of a processor. message: bytes of all
    answers. collecting, reading: seconds of a processor and by the clock. totals, files: bytes."""

    chunks: int
    tasks: int
    client: float
    committing: float
    message: int
    scheduling: float
    flying: float
    collecting: tuple[float, float]
    reading: tuple[float, float]
    totals: int
    files: int


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--chunks", type=int, nargs="+", default=[200, 1000])
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    jax_config.configure()
    columns = [
        "chunks",
        "tasks",
        "client/chunk",
        "client/task",
        "commit/chunk",
        "message/chunk",
        "scheduler/task",
        "worker/chunk",
    ]
    print(" ".join(f"{column:>14}" for column in (*columns, "collect", "by clock", "from files", "by clock", "totals")))
    for chunks in given.chunks:
        print(" ".join(f"{cell:>14}" for cell in row(measured(chunks, given.workers))), flush=True)


def row(costs: DaskCosts) -> list[str]:
    """The cells of a line."""
    chunks, tasks, client = costs.chunks, costs.tasks, costs.client
    each = [f"{1e3 * value:.2f} ms" for value in (client / chunks, client / tasks, costs.committing / chunks)]
    per = [f"{costs.message / chunks:.0f} B", f"{1e3 * costs.scheduling / tasks:.2f} ms", f"{1e3 * costs.flying / chunks:.0f} ms"]
    whole = [f"{value:.2f} s" for value in (*costs.collecting, *costs.reading)]
    return [str(chunks), str(tasks), *each, *per, *whole, f"{costs.totals / 1e6:.1f} MB"]


def measured(chunks: int, count: int) -> DaskCosts:
    """What flying a number of chunks costs."""
    overrides = [*SHORT, f"samples={chunks * LANES}"]
    problem = load(CAMPAIGN, overrides)
    runner = ChunkRunner(problem, identity(problem))
    description = RunDescription(
        identity=identity(problem),
        provenance=provenance([], overrides),
        campaign_text=problem.spec.source.text,
        samples=chunks * LANES,
        name="costs",
        inputs=problem.spec.source.inputs,
    )
    arrived: list[ChunkResult] = []
    tasks, committing = 0, 0.0
    with ExitStack() as stack:
        place = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        address, scheduler, crew = stack.enter_context(cluster(count))
        folder = stack.enter_context(RunFolder.create(place / "run", description))
        with workers(address, lambda text: None)(runner, folder) as executor:
            assert isinstance(executor, Workers)
            executor._compare()  # workers import and load the campaign

            def take(results: Sequence[ChunkResult]) -> None:
                nonlocal committing
                began = time.thread_time()
                folder.take_all(file for result in results for file in result.files)
                committing += time.thread_time() - began
                arrived.extend(results)

            before = spent([scheduler])
            time.sleep(IDLE_S)
            idle, before = (spent([scheduler]) - before) / IDLE_S, (spent([scheduler]), spent(crew))
            client, clock = cost(lambda: executor.fly(range(chunks), take))
            scheduling, flying = spent([scheduler]) - before[0] - idle * clock, spent(crew) - before[1]
            tasks = next(executor._numbers)
            results = totals(problem)
            collecting = cost(lambda: executor.fold(range(chunks), results))
        with workers(address, lambda text: None)(runner, folder) as executor:
            executor.fly([], take)  # workers load the campaign again
            again = totals(problem)
            reading = cost(lambda: executor.fold(range(chunks), again))
        assert again.encode() == results.encode()
    message = sum(len(frame) for result in arrived for frame in serialize(TaskResult((result,), (), 0.0))[1])
    size, files = len(results.encode()), sum(file.entry.bytes for result in arrived for file in result.files)
    return DaskCosts(chunks, tasks, client, committing, message, scheduling, flying, collecting, reading, size, files)


def totals(problem: Problem) -> RunAccumulator:
    """Totals without any chunk."""
    spec = problem.spec
    return RunAccumulator(spec.require, sampling_design_of(spec), spec.keep)


def cost(call: Callable[[], object]) -> tuple[float, float]:
    """Processor time of this process and time by the clock [s] that a call takes."""
    processor, clock = time.process_time(), time.perf_counter()
    call()
    return time.process_time() - processor, time.perf_counter() - clock


def spent(processes: Sequence[int]) -> float:
    """Processor time of processes so far [s]."""
    fields = [Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split() for pid in processes]
    return sum(int(ticks) for each in fields for ticks in each[11:13]) / os.sysconf("SC_CLK_TCK")


@contextmanager
def cluster(count: int) -> Generator[tuple[str, int, list[int]], None, None]:
    """A scheduler and workers of one thread: the address, the scheduler's process, those of the workers."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    environment = {**os.environ, "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False", "DASK_LOGGING__DISTRIBUTED": "error"}
    quiet = {"env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    commands = [["dask_scheduler", "--port", str(port), "--dashboard-address", ":0"]]
    commands += [["dask_worker", address, "--no-nanny", "--nthreads", "1", "--memory-limit", "0", "--no-dashboard"]] * count
    running = [subprocess.Popen([sys.executable, "-m", f"distributed.cli.{name}", *rest], **quiet) for name, *rest in commands]
    try:
        time.sleep(5.0)
        yield address, running[0].pid, [process.pid for process in running[1:]]
    finally:
        for process in running[::-1]:
            process.kill()
            process.wait()


if __name__ == "__main__":
    main()
