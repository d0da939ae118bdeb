"""rvjax as a way of flying: chunks of fixed lanes through `Flyer`, a single compiled program, a thread for each core."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import jax
import numpy as np

from rvjax.execution.bench.workload import Case, Values
from rvjax.execution.chunks import STRETCH
from rvjax.simulation.batch import LANES, Flyer, devices, streams
from rvjax.simulation.closed_loop import Drawn

MANY = 10**9
"""Steps to come, for an engine that compiles accordingly."""


def prepare(case: Case, threads: int | None = None) -> Callable[[], Values]:
    """A function that flies the case; compiles. threads: chunks at the same time, default as in `rvjax run`."""
    if case.samples % LANES:
        raise ValueError(f"{case.samples} samples do not fill chunks of {LANES}")
    flyer = Flyer.of(case.problem, threads)
    chunks = [_lanes(case.drawn, first) for first in range(0, case.samples, LANES)]
    places = devices()[:threads]
    for place in places:
        flyer.engine.begin(chunks[0], place, MANY).advance(0, 1)
        flyer.fly(chunks[0], 1, 1, device=place)

    def fly() -> Values:
        with ThreadPoolExecutor(threads or streams()) as pool:
            placed = [places[index % len(places)] for index in range(len(chunks))]
            flown = list(
                pool.map(lambda chunk, place: flyer.fly(chunk, case.steps, STRETCH, device=place).values, chunks, placed)
            )
        return {name: np.concatenate([values[name] for values in flown]) for name in flown[0]}

    return fly


def _lanes(drawn: Drawn, first: int) -> Drawn:
    return jax.tree.map(lambda x: x[first : first + LANES], drawn)
