"""Several requirements at once: which of them fail.

The joint claim "all pass" needs no correction of the confidence: it is wrong only if a requirement that is not met passes, and
that has the error probability of a single requirement (intersection-union). Naming the requirements that fail needs one.

Sources: S. Holm, Scand. J. Stat. 6 (1979) 65; R. L. Berger, Technometrics 24 (1982) 295 (intersection-union).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import invalid


def holm(p_values: ArrayLike) -> NDArray[np.float64]:
    """max over i <= j of min(1, (m - i + 1) p_(i)) for the j-th smallest of m p-values, in the order of the input.

    Rejecting all that are <= alpha rejects a true hypothesis with probability <= alpha, whatever the dependence between the
    p-values. `p_values`: (m,); ValueError unless all are between 0 and 1. Source: Holm (1979).
    """
    p = np.asarray(p_values, dtype=float)
    if p.ndim != 1 or not np.all((p >= 0) & (p <= 1)):
        raise invalid("p_values must be one row of numbers between 0 and 1", p_values)
    order = np.argsort(p, kind="stable")
    adjusted = np.empty_like(p)
    adjusted[order] = np.minimum(1, np.maximum.accumulate(np.arange(p.size, 0, -1) * p[order]))
    return adjusted
