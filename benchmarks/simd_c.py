"""SIMD C, gcc -O3 -march=native -ffast-math, OpenMP over blocks of lanes: the limit of this processor."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.c_flight import flight
from rvjax.execution.bench.workload import Case
from rvjax.simulation.flight import Carry

REGISTER_BYTES = 64


def prepare(case: Case) -> Callable[[], Carry]:
    """A function that flies the case."""
    lanes = REGISTER_BYTES // case.carry.lost_s.itemsize
    return flight(case, lanes, flags=("-O3", "-march=native", "-ffast-math", "-mprefer-vector-width=512"))
