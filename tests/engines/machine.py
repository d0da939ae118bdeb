"""Functions of numbers through the engine `llvm`, by themselves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from rvjax.simulation.engines.llvm.engine import count
from rvjax.simulation.engines.llvm.from_jaxpr import scalarised
from rvjax.simulation.engines.llvm.machine_code import Function, Target, blocks
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
    groups = -(-samples // lanes)
    rows = np.concatenate([x.reshape(samples, -1).T for x in arrays])
    given, out = blocks(groups, len(rows), lanes, real), blocks(groups, count(results), lanes, np.float64)
    whole = np.take(rows, np.arange(groups * lanes) % samples, axis=1)
    given[:] = whole.reshape(len(rows), groups, lanes).transpose(1, 0, 2)
    Function(kernel, target)(groups, 0, 1, given, given, out)
    flat = out.transpose(1, 0, 2).reshape(count(results), -1)[:, :samples]
    ends = np.cumsum([count(x) for x in results])[:-1]
    return [part.T.reshape(samples, *x.shape) for part, x in zip(np.split(flat, ends), results, strict=True)]
