"""The cost of a campaign, without flying it: samples, chunks, steps, time and memory."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rvjax.campaign.actuators import Thrusters
from rvjax.cores import cores
from rvjax.simulation.batch import LANES
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines.choice import engine_of
from rvjax.simulation.problem import Problem

STEPS_PER_S_PER_CORE = {"llvm": 2.8e6, "xla": 0.8e6}
"""Assumed speed of float64 flights by engine, cautious; measured in `docs/performance.md`."""

SLOWER = {"bounded-least-squares": 10.0}
"""Factor on the time of a step by allocation; measured in docs/model.md."""

START_S = 6
"""Assumed time to start, compile, trace the worst flights and write the report; once per controller."""

BYTES_BASE = 6e8
"""Assumed memory of the process before the first draw: JAX, compiler, tables."""


@dataclass(frozen=True)
class Cost:
    """baselines: other controllers that fly all samples. drawn: scalars drawn per sample. flights, chunks, steps: of all
    controllers together. seconds, bytes: estimates for this machine."""

    samples: int
    baselines: int
    drawn: int
    flights: int
    chunks: int
    steps: int
    seconds: float
    bytes: float

    def __str__(self) -> str:
        time = f"{self.seconds:.0f} s" if self.seconds < 120 else f"{self.seconds / 60:.0f} min"
        chunks, drawn = _counted(self.chunks, "chunk"), f"{_counted(self.drawn, 'number')} drawn for each"
        what = f"{_counted(self.samples, 'sample')} in {chunks}, {drawn}"
        if self.baselines:
            both = f"{_counted(self.samples, 'sample')} and {_counted(self.baselines, 'baseline')}"
            what = f"{both}, {_counted(self.flights, 'flight')} in {chunks}; {drawn} sample"
        return f"{what}; {_counted(self.steps, 'step')}; about {time} and {self.bytes / 1e9:.1f} GB on this machine"


def _counted(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def cost(problem: Problem) -> Cost:
    """The cost of flying all samples of a problem from the beginning, by its controller and by each baseline."""
    spec = problem.spec
    draws, _ = Draws.of(problem, np.arange(1, dtype=np.int64))
    columns = len(draws.values) + len(problem.metric_columns) + 3
    controllers = 1 + len(spec.baselines)
    chunks, flights = controllers * math.ceil(spec.samples / LANES), controllers * spec.samples
    slower = SLOWER.get(spec.actuators.allocation.use, 1.0) if isinstance(spec.actuators, Thrusters) else 1.0
    engine = engine_of(problem)
    lanes = chunks * LANES if engine.fixed_lanes else flights
    flown = slower * lanes * spec.horizon.steps / (STEPS_PER_S_PER_CORE[engine.name] * cores())
    return Cost(
        samples=spec.samples,
        baselines=len(spec.baselines),
        drawn=len(draws.values),
        flights=flights,
        chunks=chunks,
        steps=flights * spec.horizon.steps,
        seconds=controllers * START_S + flown,
        bytes=BYTES_BASE + 3.0 * 8.0 * columns * spec.samples,
    )
