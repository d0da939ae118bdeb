"""Functions of numbers through the engine `llvm`, by themselves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from rvjax.simulation.engines.llvm.engine import count
from rvjax.simulation.engines.llvm.from_jaxpr import scalarised
from rvjax.simulation.engines.llvm.machine_code import Function, Target, blocks, packed, unpacked
from rvjax.simulation.engines.llvm.text import Kernel

Array = np.ndarray[Any, Any]


def machine(function: Callable[..., Any], *arrays: Array, lanes: int = 8, target: Target | None = None) -> list[Array]:
    """function(*arrays) for every sample, as float64. arrays: (samples, …) in the type of the first."""
    real = arrays[0].dtype
    shapes = [jax.ShapeDtypeStruct(x.shape[1:], real) for x in arrays]
    program, tree = scalarised(function, *shapes, step=False)
    results = jax.tree.leaves(tree)
    kernel = Kernel(program, count(shapes), 0, lanes, real, np.dtype(np.float64))
    samples = len(arrays[0])
    given = packed(np.concatenate([x.reshape(samples, -1).T for x in arrays]), lanes)
    out = blocks(len(given), count(results), lanes, np.float64)
    Function(kernel, target)(len(given), 0, 1, given, given, out)
    flat = unpacked(out, samples)
    ends = np.cumsum([count(x) for x in results])[:-1]
    return [part.T.reshape(samples, *x.shape) for part, x in zip(np.split(flat, ends), results, strict=True)]


def same(ours: Any, theirs: Any) -> bool:
    """Equal numbers with the same sign of zero; NaN in the same places."""
    a, b = np.asarray(ours, np.float64), np.asarray(theirs, np.float64)
    return bool(np.array_equal(a, b, equal_nan=True) and np.array_equal(np.signbit(a[a == 0]), np.signbit(b[b == 0])))
