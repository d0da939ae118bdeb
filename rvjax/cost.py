"""What a campaign will cost: samples, chunks, steps, time and memory, without flying it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rvjax import process
from rvjax.batch import LANES
from rvjax.campaign import Problem
from rvjax.draw import Draws
from rvjax.spec.actuators import Thrusters

STEPS_PER_S_PER_CORE = 1.2e6
"""Assumed speed of float64 flights, a cautious one; `docs/performance.md` has a measurement."""

SLOWER = {"bounded-least-squares": 10.0}
"""How many times longer a step takes with an allocation; docs/model.md has a measurement."""

START_S = 14.0
"""Assumed time to start, compile, trace the worst flights and write the report."""

BYTES_BASE = 6e8
"""Assumed memory of the process before anything is drawn: JAX, compiler, tables."""


@dataclass(frozen=True)
class Cost:
    """drawn: scalars drawn for each sample. steps: of integration, of all samples. seconds, bytes: estimates on this machine."""

    samples: int
    drawn: int
    chunks: int
    steps: int
    seconds: float
    bytes: float

    def __str__(self) -> str:
        time = f"{self.seconds:.0f} s" if self.seconds < 120 else f"{self.seconds / 60:.0f} min"
        return (
            f"{self.samples:,} samples in {self.chunks:,} chunks, {self.drawn} numbers drawn for each; {self.steps:,} steps; "
            f"about {time} and {self.bytes / 1e9:.1f} GB on this machine"
        )


def cost(problem: Problem) -> Cost:
    """The cost of flying all samples of a problem from the beginning."""
    spec = problem.spec
    draws, _ = Draws.of(problem, np.arange(1, dtype=np.int64))
    columns = len(draws.values) + len(problem.metric_columns) + 3
    chunks = math.ceil(spec.samples / LANES)
    steps = spec.samples * spec.horizon.steps
    slower = SLOWER.get(spec.actuators.allocation, 1.0) if isinstance(spec.actuators, Thrusters) else 1.0
    flown = slower * chunks * LANES * spec.horizon.steps / (STEPS_PER_S_PER_CORE * process.cores())
    return Cost(spec.samples, len(draws.values), chunks, steps, START_S + flown, BYTES_BASE + 3.0 * 8.0 * columns * spec.samples)
