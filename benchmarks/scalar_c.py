"""Scalar C, gcc -O2, OpenMP over the samples: what a colleague writes in an afternoon."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.c_flight import flight
from rvjax.execution.bench.workload import Case
from rvjax.simulation.flight import Carry


def prepare(case: Case) -> Callable[[], Carry]:
    """A function that flies the case."""
    return flight(case, lanes=None, flags=("-O2",))
