"""`python -m tests.physics.same_bits NAME …`: prints name:type:(numbers whose bits differ between NumPy and jax.jit).

Out of 10⁵ numbers of all sizes. XLA takes numbers below the smallest normal one for zero: where the argument, the result or a
term is that small nothing is compared.
"""

from __future__ import annotations

import sys

import jax
import numpy as np

from rvjax.physics import elementary
from tests.oracles.elementary_truth import TRUTHS, arguments
from tests.oracles.jaxpr_numpy import evaluate

for name in sys.argv[1:]:
    for kind in (np.float64, np.float32):
        x = arguments(TRUTHS[name], kind, 30000)[:100000]
        function = getattr(elementary, name)
        ours, theirs = evaluate(function, x), np.asarray(jax.jit(function)(x))
        tiny = 1024.0 * np.finfo(kind).tiny  # terms of a result are smaller than the result
        subnormal = (np.abs(x) < tiny) | (np.abs(ours) < tiny)
        differ = (ours != theirs) & ~(np.isnan(ours) & np.isnan(theirs)) & ~subnormal
        print(f"{name}:{kind.__name__}:{np.count_nonzero(differ)}")
