"""What a whole run costs beside flying: `python -m benchmarks.runs [overhead] [dask] [memory]`, all three by default.

overhead: share of a run of benchmarks/docking.yaml that goes into writing, syncing and comparing files, and into reading them
back.
dask: pace of two local Dask workers of one thread over that of the threads of one process, in turn, first chunk to last.
memory: peak of a whole run, report included, of 10⁴ and of 10⁶ samples of a flight of 5 s, each in a process of its own.
What came out: docs/reliability.md.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Generator
from pathlib import Path
from statistics import median
from typing import Any

from rvjax.execution.executors import ExecutorFactory
from rvjax.execution.executors.dask_client import workers
from rvjax.execution.executors.threads import local_threads
from rvjax.execution.run import run
from rvjax.run_folder import RunFolder
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES

CAMPAIGN = Path(__file__).with_name("docking.yaml")
CHUNKS = 40
ROUNDS = 3
SHORT = (
    "horizon={duration_s: 5, step_s: 0.05}",
    "capture={position_m: 100, attitude_mrp: 1, window_s: 1}",
    "faults.effectiveness.onset_s={uniform: [1, 4]}",
    "faults.bias.onset_s={uniform: [1, 4]}",
)


def overhead() -> None:
    """Prints the shares."""
    spent = {"commit": 0.0, "read back": 0.0}
    take, tables = RunFolder.take, RunFolder.tables

    def timed_take(*given: Any) -> None:
        began = time.perf_counter()
        take(*given)
        spent["commit"] += time.perf_counter() - began

    def timed_tables(*given: Any) -> Generator[Any, None, None]:
        began = time.perf_counter()
        for table in tables(*given):
            spent["read back"] += time.perf_counter() - began
            yield table
            began = time.perf_counter()
        spent["read back"] += time.perf_counter() - began

    RunFolder.take, RunFolder.tables = timed_take, timed_tables
    with tempfile.TemporaryDirectory() as place:
        began = time.perf_counter()
        run(CAMPAIGN, Path(place) / "run")
        whole = time.perf_counter() - began
    RunFolder.take, RunFolder.tables = take, tables
    shares = ", ".join(f"{name} {100 * time_s / whole:.2f} %" for name, time_s in spent.items())
    print(f"overhead of {CAMPAIGN.name}: {shares} of {whole:.1f} s; together {100 * sum(spent.values()) / whole:.2f} %")


def pace(campaign: Path, crew: ExecutorFactory, chunks: int) -> float:
    """Seconds a chunk, from the first that is committed to the last."""
    times: list[tuple[float, int]] = []
    with tempfile.TemporaryDirectory() as place:
        samples = f"samples={chunks * LANES}"
        run(
            campaign,
            Path(place) / "run",
            [samples],
            progress=lambda progress: times.append((time.perf_counter(), progress.done)) if progress.phase == "flights" else None,
            executor=crew,
        )
    began, first = next(time for time in times if time[1])
    ended, last = next(time for time in times if time[1] == times[-1][1])
    return (ended - began) / ((last - first) / LANES)


def dask() -> None:
    """Prints the ratio of the paces."""
    ratios: list[float] = []
    for _ in range(ROUNDS):
        alone, shared = (pace(CAMPAIGN, crew, CHUNKS) for crew in (local_threads, workers(2, lambda text: None)))
        ratios.append(alone / shared)
        print(f"a chunk every {alone:.3f} s inline, every {shared:.3f} s by two Dask workers: ratio {ratios[-1]:.3f}", flush=True)
    print(f"Dask over inline, median of {ROUNDS}: {median(ratios):.3f}")


def memory() -> None:
    """Prints the peaks."""
    peaks: dict[int, float] = {}
    for samples in (10**4, 10**6):
        command = [sys.executable, "-m", "benchmarks.runs", f"--child={samples}"]
        peaks[samples] = float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        print(f"{samples} samples: {peaks[samples]:.0f} MB at most", flush=True)
    print(f"10⁴ → 10⁶ samples: {100 * (peaks[10**6] / peaks[10**4] - 1):+.1f} %")


def child(samples: int) -> None:
    """A run in this process; its peak in MB."""
    with tempfile.TemporaryDirectory() as place:
        run(CAMPAIGN, Path(place) / "run", [*SHORT, f"samples={samples}"])
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)


def main() -> None:
    """Runs what the arguments say."""
    jax_config.configure()
    parts: dict[str, Callable[[], None]] = {"overhead": overhead, "dask": dask, "memory": memory}
    given = sys.argv[1:]
    if given and given[0].startswith("--child="):
        child(int(given[0].partition("=")[2]))
        return
    for part in given or parts:
        parts[part]()


if __name__ == "__main__":
    main()
