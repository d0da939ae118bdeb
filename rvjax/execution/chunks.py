"""Chunks of a campaign, flown by their numbers.

A chunk is a pure function of its number and the run's identity: the process, the time and the number of flights do not matter.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rvjax.run_folder import DataFile
from rvjax.run_folder.entry import Key
from rvjax.run_folder.manifest import digest
from rvjax.simulation import tables
from rvjax.simulation.batch import LANES, Flown, Flyer, devices
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem
from rvjax.timings import phase

ENVELOPE_CHUNKS = 5
"""Envelopes over time are kept of the first chunks, up to this number; their samples are drawn like all others."""

ENVELOPE_INSTANTS = 120
STRETCH = 250
"""Fewest steps between two checks for a stop request: a fraction of a second."""


class Segment(NamedTuple):
    """Totals that a worker process keeps until they are collected. worker: its address. name: no other segment has it."""

    worker: str
    name: str


class ChunkResult(NamedTuple):
    """The data files of a flown chunk, the samples table last. segment: where a worker has added the table to totals; None
    where the table is still to be added."""

    chunk: int
    files: tuple[DataFile, ...]
    segment: Segment | None = None

    @property
    def samples(self) -> int:
        """Its number of samples; lanes after the last sample are dropped."""
        return self.files[-1].entry.count


class ChunkRunner:
    """Compiles at the first chunk; threads may share it. identity: the run's; every data file carries it. threads:
    that fly at a time; all cores by default."""

    def __init__(self, problem: Problem, identity: Mapping[str, Any], threads: int | None = None) -> None:
        self.problem = problem
        self.flyer = Flyer.of(problem, threads)
        self._digest = digest(identity)

    def steps_flown(self) -> int:
        """Steps that its chunks have flown so far, in all threads."""
        return self.flyer.steps_flown

    def fly_chunk(self, chunk: int) -> ChunkResult:
        """Draws and flies a chunk, and encodes its tables."""
        problem, first = self.problem, chunk * LANES
        lanes = self.flyer.lanes(self._samples(chunk))
        with phase("draw"):
            draws, drawn = Draws.of(problem, np.arange(first, first + lanes, dtype=np.int64))
        envelope, places = chunk < ENVELOPE_CHUNKS, devices()
        every = _every(problem) if envelope else max(_every(problem), STRETCH)
        with phase("fly"):
            flown = self.flyer.fly(
                drawn, problem.spec.horizon.steps, every, with_envelope=envelope, device=places[chunk % len(places)]
            )
        with phase("write"):
            return ChunkResult(chunk, self._files(chunk, draws, flown))

    def _samples(self, chunk: int) -> int:
        return min(LANES, self.problem.spec.samples - chunk * LANES)

    def _files(self, chunk: int, draws: Draws, flown: Flown) -> tuple[DataFile, ...]:
        problem = self.problem
        rows = slice(0, self._samples(chunk))
        files: list[DataFile] = []
        if chunk < ENVELOPE_CHUNKS:
            histories = tables.envelope_table(flown, _instants(problem), draws.samples, rows)
            files.append(DataFile.of(Key("envelopes", chunk), histories, tables.ENVELOPE, self._digest))
        table = tables.samples_table(problem, draws, flown, rows)
        return (*files, DataFile.of(Key("samples", chunk), *table, self._digest))


def _every(problem: Problem) -> int:
    return math.ceil(problem.spec.horizon.steps / ENVELOPE_INSTANTS)


def _instants(problem: Problem) -> NDArray[np.float64]:
    """Times of the observed steps [s], the last step always among them."""
    steps = problem.spec.horizon.steps
    return np.array([*range(0, steps, _every(problem)), steps]) * problem.spec.horizon.step_s
