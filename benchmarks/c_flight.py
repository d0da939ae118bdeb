"""Compiling the C code of a step (`benchmarks.c_code`) with gcc, and flying it."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import jax
import numpy as np
from numpy.typing import NDArray

from benchmarks import c_code
from rvjax.execution.bench.workload import Case, UnavailableError
from rvjax.simulation.flight import Carry


def flight(case: Case, lanes: int | None, flags: tuple[str, ...]) -> Callable[[], Carry]:
    """A function that flies the case in C. lanes: samples side by side, None: one after the other.

    -ffast-math lets gcc assume that no number is infinite or NaN, so samples that are lost may come out as anything.
    """
    compiler = shutil.which("gcc")
    if compiler is None:
        raise UnavailableError("there is no gcc")
    sample = jax.tree.map(lambda x: x[0], (case.drawn, case.carry))
    step = jax.make_jaxpr(case.step)(*sample, 0)
    drawn, start = (np.stack(jax.tree.leaves(tree)) for tree in (case.drawn, case.carry))
    try:
        source = (
            c_code.scalar(step, len(drawn), case.precision)
            if lanes is None
            else c_code.simd(step, len(drawn), case.precision, lanes)
        )
    except c_code.NoScalarError as error:
        raise UnavailableError(f"{error}; benchmarks/docking.yaml is such a campaign") from error
    with tempfile.TemporaryDirectory() as place:
        (Path(place) / "flight.c").write_text(source)
        for command in (  # linked without the flags: -ffast-math would set the whole process to flush small numbers to zero
            [compiler, *flags, "-fopenmp", "-fPIC", "-c", "flight.c"],
            [compiler, "-fopenmp", "-shared", "-o", "flight.so", "flight.o", "-lm"],
        ):
            done = subprocess.run(command, cwd=place, capture_output=True, text=True, check=False)
            if done.returncode:
                raise UnavailableError(f"gcc failed: {done.stderr[:300]}")
        library = ctypes.CDLL(str(Path(place) / "flight.so"))

    def fly() -> Carry:
        carry = start.copy()
        library.fly(*map(ctypes.c_long, (case.samples, 0, case.steps)), _address(drawn), _address(carry))
        return jax.tree.unflatten(jax.tree.structure(case.carry), list(carry))

    return fly


def _address(array: NDArray[np.floating]) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)
