"""Campaigns of 10⁶ to 10¹⁰ samples on up to 10,000 cores, simulated: `python -m benchmarks.scale [CAMPAIGN] [--price P]`.

The costs are measured here: of a chunk, of a task and of merging totals. The simulation then passes every task, one after the
other, through

    a core        flies the chunks of a task; each core has `AHEAD` tasks, one flies and one waits
    scheduler     one process, for each task
    client        one process: for each task, and for each of its chunks reading back, comparing, the journal

and ends with the merging of the totals. Each stage serves in the order of arrival. What waits for what shows by itself.
`--check` also flies the campaign on two local workers and prints the ratio of the times. What came out: docs/performance.md.
"""

from __future__ import annotations

import argparse
import dataclasses
import heapq
import math
import random
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from hashlib import sha256
from itertools import islice, product
from pathlib import Path
from statistics import median
from typing import NamedTuple

from benchmarks import dask_costs
from benchmarks.runs import pace
from rvjax.execution.chunks import ENVELOPE_CHUNKS, ChunkRunner
from rvjax.execution.executors.dask_client import AHEAD, MOST_CHUNKS, TASK_S, TASKS_A_SECOND, workers
from rvjax.execution.identity import identity
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES
from rvjax.simulation.problem import load

CAMPAIGN = Path(__file__).with_name("docking.yaml")
SENT, FLOWN_BY_CORE, ANSWERED = range(3)
SIMULATED = 100_000
"""Tasks."""

MEGA = 10_000_000
FLOWN = 8
CHUNKS = 1000
CHECKED = 60
IMPORTS_S = 2.0
SAMPLES = (10**6, 10**8, 10**10)
CORES = (100, 1_000, 10_000)
ENTRY_BYTES = 46
"""Of a chunk in the list of the run folder (`python -m benchmarks.scan`)."""


@dataclass(frozen=True)
class Costs:
    """Seconds on one core. flight: of a chunk. start: of a worker. chunk, task: of the client. scheduling: of a task. merge: of
    the totals of two workers. size: bytes of the files of a chunk."""

    flight: float
    start: float
    chunk: float
    task: float
    scheduling: float
    merge: float
    size: float


class Ended(NamedTuple):
    """What a simulation found: seconds to the end, and the parts of them in which cores, scheduler and client were busy."""

    seconds: float
    cores: float
    scheduler: float
    client: float

    @property
    def limit(self) -> str:
        """What the run waits for."""
        if self.cores > 0.9:
            return "flying"
        return max(("scheduler", "client"), key=lambda name: getattr(self, name)) if max(self[2:]) > 0.9 else "start and end"


def simulated(costs: Costs, chunks: int, cores: int) -> Ended:
    """A run. Of a long run the first `SIMULATED` tasks fly, and the rest at their pace."""
    sizes = list(islice(tasks(costs, chunks, cores), SIMULATED + AHEAD * cores))
    run = Run(costs, cores, sizes)
    run.fly()
    longer = chunks / sum(sizes)
    merging = costs.merge * math.ceil(math.log2(cores) / 3)  # eight at a time
    seconds = costs.start + (run.now - costs.start) * longer + merging
    return Ended(seconds, *(longer * run.busy[name] / seconds for name in ("cores", "scheduler", "client")))


class Run:
    """The stages of a run: cores, scheduler and client, each with the time at which it is free. Times of tasks vary by ± 10 %."""

    def __init__(self, costs: Costs, cores: int, sizes: list[int]) -> None:
        self.now, self.busy = 0.0, {"cores": 0.0, "scheduler": 0.0, "client": 0.0}
        self._costs, self._cores, self._todo = costs, cores, iter(sizes)
        self._free = {"scheduler": 0.0, "client": 0.0}
        self._core_free = [costs.start] * cores
        self._events: list[tuple[float, int, int, int]] = []
        self._scatter = random.Random(1)

    def fly(self) -> None:
        """Passes all tasks through the stages, in the order in which they arrive at each."""
        for _, core in product(range(AHEAD), range(self._cores)):
            self._submit(0.0, core)
        while self._events:
            time, stage, core, size = heapq.heappop(self._events)
            self._arrive(time, stage, core, size)

    def _arrive(self, time: float, stage: int, core: int, size: int) -> None:
        costs = self._costs
        if stage == SENT:
            begins = max(self._core_free[core], self._served("scheduler", time, costs.scheduling / 2))
            flight = size * costs.flight * self._scatter.uniform(0.9, 1.1)
            self._core_free[core] = begins + flight
            self.busy["cores"] += flight / self._cores
            heapq.heappush(self._events, (begins + flight, FLOWN_BY_CORE, core, size))
        elif stage == FLOWN_BY_CORE:
            heapq.heappush(self._events, (self._served("scheduler", time, costs.scheduling / 2), ANSWERED, core, size))
        else:
            self.now = self._served("client", time, costs.task / 2 + size * costs.chunk)
            self._submit(self.now, core)

    def _submit(self, time: float, core: int) -> None:
        if size := next(self._todo, 0):
            heapq.heappush(self._events, (self._served("client", time, self._costs.task / 2), SENT, core, size))

    def _served(self, stage: str, time: float, seconds: float) -> float:
        """When a stage that is given work at a time has done it."""
        self._free[stage] = max(self._free[stage], time) + seconds
        self.busy[stage] += seconds
        return self._free[stage]


def tasks(costs: Costs, chunks: int, cores: int) -> Iterator[int]:
    """The numbers of chunks of the tasks, as `dask_client` chooses them."""
    long_enough = int(max(TASK_S, cores / TASKS_A_SECOND) / costs.flight)
    while chunks:
        size = max(1, min(long_enough, MOST_CHUNKS, chunks // (AHEAD * cores)))
        yield size
        chunks -= size


def measured(campaign: Path) -> Costs:
    """The costs of a campaign on this machine."""
    problem = load(campaign, [f"samples={(ENVELOPE_CHUNKS + FLOWN) * LANES}"])
    runner = ChunkRunner(problem, identity(problem), threads=1)
    start = _seconds(lambda: runner.fly_chunk(ENVELOPE_CHUNKS))
    flights: list[float] = []
    sizes: list[int] = []
    for chunk in range(ENVELOPE_CHUNKS + 1, ENVELOPE_CHUNKS + FLOWN):
        began = time.perf_counter()
        result = runner.fly_chunk(chunk)
        flights.append(time.perf_counter() - began)
        sizes.append(sum(file.entry.bytes for file in result.files))
    dask = dask_costs.measured(CHUNKS, 2)
    larger = median(sizes) - dask.files / dask.chunks
    return Costs(
        flight=median(flights),
        start=IMPORTS_S + start,
        chunk=dask.committing / dask.chunks + larger * _seconds(lambda: sha256(bytes(MEGA))) / MEGA,
        task=(dask.client - dask.committing) / dask.tasks,
        scheduling=dask.scheduling / dask.tasks,
        merge=dask.collecting[1],
        size=median(sizes),
    )


def _seconds(call: Callable[[], object]) -> float:
    began = time.perf_counter()
    call()
    return time.perf_counter() - began


def main() -> None:
    """Prints what was measured, and the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("campaign", nargs="?", type=Path, default=CAMPAIGN)
    parser.add_argument("--price", type=float, default=0.04, help="of a core for an hour, in whatever currency")
    parser.add_argument("--check", action="store_true", help="compare the simulation with a real run on two local workers")
    given = parser.parse_args()
    jax_config.configure()
    costs = measured(given.campaign)
    print(f"measured with {given.campaign.name}, {LANES} samples a chunk:")
    for name, value in vars(costs).items():
        print(f"  {name:10} {value / 1e3:.0f} kB" if name == "size" else f"  {name:10} {1e3 * value:.3g} ms")
    print(f"the client is full at {costs.flight / (costs.chunk + costs.task / MOST_CHUNKS):,.0f} cores")
    head = ("samples", "cores", "time", "cores busy", "scheduler", "client", "core hours", "price", "files", "list", "limit")
    print(" ".join(f"{word:>10}" for word in head))
    for samples, cores in product(SAMPLES, CORES):
        print(" ".join(f"{cell:>10}" for cell in row(costs, samples, cores, given.price)), flush=True)
    if given.check:
        check(costs, given.campaign)


def row(costs: Costs, samples: int, cores: int, price: float) -> tuple[str, ...]:
    """The cells of a line."""
    chunks = math.ceil(samples / LANES)
    ended = simulated(costs, chunks, cores)
    hours = ended.seconds / 3600 * cores
    shares = (f"{100 * share:.0f} %" for share in (ended.cores, ended.scheduler, ended.client))
    sizes = (in_bytes(chunks * costs.size), in_bytes(chunks * ENTRY_BYTES))
    return (
        f"{samples:.0e}",
        f"{cores:,}",
        in_words(ended.seconds),
        *shares,
        f"{hours:,.0f}",
        f"{hours * price:,.2f}",
        *sizes,
        ended.limit,
    )


def in_bytes(size: float) -> str:
    """A number of bytes with its unit."""
    power = min(4, max(1, int(math.log10(max(size, 1.0))) // 3))
    return f"{size / 1000**power:.3g} {('kB', 'MB', 'GB', 'TB')[power - 1]}"


def in_words(seconds: float) -> str:
    """A time with its unit."""
    for name, length in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.1f} {name}"
    return f"{seconds:.0f} s"


def check(costs: Costs, campaign: Path) -> None:
    """The simulation of two cores beside two local workers."""
    flown = pace(campaign, workers(2, lambda text: None), CHECKED)
    told = simulated(dataclasses.replace(costs, start=0.0, merge=0.0), CHECKED, 2).seconds / CHECKED
    print(f"two Dask workers: a chunk every {flown:.3f} s, simulated {told:.3f} s: ratio {flown / told:.2f}")


if __name__ == "__main__":
    main()
