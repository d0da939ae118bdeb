"""Growth of time and memory with the samples: `python -m rvjax.execution.bench.scaling '{"samples": …}'`, a process each.

Samples are drawn, flown over a short horizon and dropped, through the same stream of chunks that a run writes from.
"""

from __future__ import annotations

import json
import math
import sys
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rvjax.simulation.problem import Problem


MIN_S = 3.0
"""Few samples are flown again until this time has passed."""


def main(spec: dict[str, Any]) -> None:
    """spec: campaign, samples, steps, precision."""
    from rvjax.simulation.jax_config import configure

    configure(spec["precision"])
    from rvjax.execution.bench.worker import forget_peak, peak_mb, say
    from rvjax.execution.chunks import ENVELOPE_CHUNKS, ChunkResult, ChunkRunner
    from rvjax.execution.executors.threads import map_in_threads
    from rvjax.simulation.batch import LANES
    from rvjax.simulation.problem import load

    chunks = range(ENVELOPE_CHUNKS, ENVELOPE_CHUNKS + math.ceil(spec["samples"] / LANES))
    problem = shortened(load(spec["campaign"]), spec["steps"], chunks.stop * LANES)
    runner = ChunkRunner(problem, {})
    lanes = 0

    def take(result: ChunkResult) -> None:
        nonlocal lanes
        lanes += result.samples

    map_in_threads(
        runner.fly_chunk, range(ENVELOPE_CHUNKS), take, runner.flyer.stop
    )  # compiles; only these chunks keep envelopes
    forget_peak()
    lanes, times, started = 0, 0, time.perf_counter()
    while time.perf_counter() - started < MIN_S:
        map_in_threads(runner.fly_chunk, chunks, take, runner.flyer.stop)
        times += 1
    spent = time.perf_counter() - started
    if lanes != times * len(chunks) * LANES:
        raise RuntimeError(f"{lanes} lanes arrived from {times} times {len(chunks)} chunks")
    say(seconds=spent / times, steps=spec["samples"] * spec["steps"], peak_memory_mb=peak_mb())  # padding lanes are not counted


def shortened(problem: Problem, steps: int, samples: int) -> Problem:
    """The problem with another number of samples and steps. No override: a closing window or an onset need not fit into it."""
    spec = problem.spec
    horizon = spec.horizon.model_copy(update={"duration_s": steps * spec.horizon.step_s})
    return replace(problem, spec=spec.model_copy(update={"horizon": horizon, "samples": samples}))


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
