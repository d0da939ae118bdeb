"""`python -m tests.physics.same_bits NAME …`: prints name:type:(numbers whose bits differ between NumPy and jax.jit).

Out of 10⁵ numbers of all sizes. XLA takes numbers below the smallest normal one for zero: where an argument, the result or a
term is that small nothing is compared.
"""

from __future__ import annotations

import sys
from typing import Any

import jax
import numpy as np
from numpy.typing import NDArray

from rvjax.physics import elementary
from tests.oracles.elementary_truth import TRUTHS, arguments, pairs
from tests.oracles.jaxpr_numpy import evaluate

COUNT = 100000


def drawn(name: str, kind: type[np.floating[Any]]) -> tuple[NDArray[Any], ...]:
    """The arguments of a function."""
    if name in ("power", "atan2"):
        return tuple(x[-COUNT:] for x in pairs(name, kind, COUNT))
    return (arguments(TRUTHS[{"sin": "tan", "cos": "tan"}.get(name, name)], kind, COUNT // 3)[:COUNT],)


for name in sys.argv[1:]:
    for kind in (np.float64, np.float32):
        x = drawn(name, kind)
        function = getattr(elementary, name)
        ours, theirs = evaluate(function, *x), np.asarray(jax.jit(function)(*x))
        tiny = 2.0**26 * np.finfo(kind).tiny  # terms of a result are smaller than the result
        compared = np.all([np.abs(v) > tiny for v in (*x, ours)], axis=0) | np.isnan(ours)
        differ = (ours != theirs) & ~(np.isnan(ours) & np.isnan(theirs)) & compared
        print(f"{name}:{kind.__name__}:{np.count_nonzero(differ)}")
