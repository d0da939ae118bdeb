"""What a campaign of 10⁶, 10⁸, 10¹⁰ samples takes: `python -m benchmarks.scale [CAMPAIGN] [--price P] [--dask]`.

Measured here, per chunk: flying on one core, taking in (write, fsync, compare, fold), reading back, bytes; per task, Dask's
scheduler with chunks that take no time; per file, the scan of a folder that is gone on with. The model is three stages that work
beside each other, so the slowest decides:

    workers     chunks · flight / (workers · cores each)
    scheduler   chunks · task
    client      chunks · (take in + read back + fold)    one process, one journal

plus the start-up of a worker. `--dask` also flies the campaign with two local workers and compares the time with the model's.
What came out: docs/performance.md.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from collections.abc import Callable, Iterable
from itertools import islice
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from benchmarks.scan import build, resume
from rvjax.components.samplers import sampling_design_of
from rvjax.run_folder import RunDescription, RunFolder

CAMPAIGN = Path(__file__).parents[1] / "campaigns" / "docking-faulted.yaml"
FLOWN = 12
MANY = 200
TASKS = 2000
FILES = 20_000
CHECKED = 60
SAMPLES = (10**6, 10**8, 10**10)
WORKERS = (1, 100, 1000)
CORES_EACH = 8


class Costs(NamedTuple):
    """Seconds and bytes for each chunk; task: scheduler's seconds for each task; scan: seconds for each file on going on."""

    flight: float
    take_in: float
    fold: float
    read_back: float
    bytes: float
    task: float
    scan: float
    start: float


def main() -> None:
    """Prints what was measured, and the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("campaign", nargs="?", type=Path, default=CAMPAIGN)
    parser.add_argument("--price", type=float, default=0.04, help="of a core for an hour, in whatever currency")
    parser.add_argument("--dask", action="store_true", help="compare the model with a real flight on two local workers")
    given = parser.parse_args()
    from rvjax.simulation import jax_config
    from rvjax.simulation.batch import LANES

    jax_config.configure()
    costs = measure(given.campaign)
    print(f"measured with {given.campaign.name}, {LANES} samples a chunk:")
    for name, value in costs._asdict().items():
        print(f"  {name:10} {value / 1e3:.0f} kB" if name == "bytes" else f"  {name:10} {1e3 * value:.3g} ms")
    print(f"\n{'samples':>8} {'workers':>8} {'time':>10} {'core hours':>11} {'price':>10} {'storage':>9}  limit")
    for samples in SAMPLES:
        for workers in WORKERS:
            print(row(costs, samples, workers, given.price, LANES))
    if given.dask:
        compare(costs, given.campaign)


def row(costs: Costs, samples: int, workers: int, price: float, lanes: int) -> str:
    """One line of the table."""
    chunks = math.ceil(samples / lanes)
    stages = {
        "workers": chunks * costs.flight / (workers * CORES_EACH),
        "scheduler": chunks * costs.task,
        "client": chunks * (costs.take_in + costs.read_back + costs.fold),
    }
    limit = max(stages, key=lambda name: stages[name])
    spent = costs.start + stages[limit]
    hours = spent / 3600 * workers * CORES_EACH
    size = chunks * costs.bytes
    unit = next(unit for unit in ("EB", "PB", "TB", "GB", "MB") if size >= UNITS[unit] or unit == "MB")
    cells = (
        f"{samples:8.0e} {workers:8d} {said(spent):>10} {hours:11,.0f} {hours * price:10,.0f} {size / UNITS[unit]:6.1f} {unit}"
    )
    return f"{cells}  {limit}"


UNITS = {"MB": 1e6, "GB": 1e9, "TB": 1e12, "PB": 1e15, "EB": 1e18}


def said(seconds: float) -> str:
    """A time as people say it."""
    for name, length in (("years", 3.156e7), ("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.1f} {name}"
    return f"{seconds:.0f} s"


def measure(campaign: Path) -> Costs:
    """Everything but Dask's figures on the campaign's own chunks, all on one thread."""
    from rvjax.analysis.accumulator import RunAccumulator
    from rvjax.execution.chunks import ENVELOPE_CHUNKS, ChunkResult, ChunkRunner
    from rvjax.execution.identity import identity, provenance
    from rvjax.simulation.batch import LANES
    from rvjax.simulation.problem import load

    problem = load(campaign, [f"samples={(ENVELOPE_CHUNKS + FLOWN) * LANES}"])
    mine = identity(problem)
    started = time.perf_counter()
    runner = ChunkRunner(problem, mine)
    runner.fly_chunk(ENVELOPE_CHUNKS)
    start = time.perf_counter() - started
    results: list[ChunkResult] = []
    chunks = range(ENVELOPE_CHUNKS, ENVELOPE_CHUNKS + FLOWN)
    flight = each(chunks, lambda chunk: results.append(runner.fly_chunk(chunk)))
    with tempfile.TemporaryDirectory() as place:
        spec = problem.spec
        description = RunDescription(
            identity=mine, provenance=provenance([], []), campaign_text=spec.source.text, samples=spec.samples, name="scale"
        )
        with RunFolder.create(Path(place) / "run", description) as folder:
            take_in = each(results, lambda result: folder.take(result.files[-1]))
            read = {chunk: next(folder.tables([chunk])) for chunk in chunks}
            read_back = each(chunks, lambda chunk: next(folder.tables([chunk])))
        began = time.perf_counter()
        fold = RunAccumulator(problem.spec.require, sampling_design_of(problem.spec))
        for chunk in range(MANY):
            _, frame, columns = read[chunks[chunk % FLOWN]]
            fold.add(chunk, frame.assign(sample=range(chunk * LANES, (chunk + 1) * LANES)), columns)
        fold.totals.worst  # noqa: B018 (takes in what waits)
        folding = (time.perf_counter() - began) / MANY
    size = median(result.files[-1].entry.bytes for result in results)
    return Costs(flight, take_in, folding, read_back, size, task_s(), scan_s(), start)


def task_s() -> float:
    """Seconds of Dask's scheduler and client for each of many chunks that take no time, two workers."""
    from distributed import Client, LocalCluster, as_completed

    local = {"dashboard_address": "127.0.0.1:0", "memory_limit": 0, "silence_logs": "ERROR"}
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, **local) as cluster, Client(cluster) as client:
        client.gather(client.map(abs, range(10), pure=False))
        began = time.perf_counter()
        todo = iter(range(TASKS))
        flying = as_completed([client.submit(abs, next(todo), pure=False) for _ in range(64)])
        for future in flying:
            future.result()
            for chunk in islice(todo, 1):
                flying.add(client.submit(abs, chunk, pure=False))
        return (time.perf_counter() - began) / TASKS


def scan_s() -> float:
    """Seconds for each file when a folder is gone on with."""
    with tempfile.TemporaryDirectory() as place:
        build(Path(place) / "run", FILES, closed=True)
        began = time.perf_counter()
        resume(Path(place) / "run", FILES)
        return (time.perf_counter() - began) / FILES


def compare(costs: Costs, campaign: Path) -> None:
    """The model against flights by this process and by two local workers of one thread."""
    from benchmarks.runs import pace
    from rvjax.execution.executors.dask_client import workers
    from rvjax.execution.executors.threads import local_threads

    for name, crew in (("threads", local_threads), ("two Dask workers", workers(2, lambda text: None))):
        found = pace(campaign, crew, CHECKED)
        told = max(
            costs.flight / 2, costs.take_in + costs.read_back + costs.fold, costs.task if crew is not local_threads else 0.0
        )
        print(f"{name}: {found:.3f} s a chunk on two cores, the model says {told:.3f}: ratio {found / told:.2f}")


def each(things: Iterable[Any], do: Callable[[Any], object]) -> float:
    """Median seconds of doing something with each."""
    spent: list[float] = []
    for one in things:
        began = time.perf_counter()
        do(one)
        spent.append(time.perf_counter() - began)
    return median(spent)


if __name__ == "__main__":
    main()
