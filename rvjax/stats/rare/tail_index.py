"""Pareto k̂: the shape of a generalized Pareto law fitted to the largest weights.

    tail: the largest min(n/5, 3 √n) weights, less the largest below them;    k̂ > 0.7: the mean of the weights is not to be
    trusted

Sources: J. Zhang, M. A. Stephens, "A new and efficient estimation method for the generalized Pareto distribution", Technometrics
51 (2009) 316; A. Vehtari and others, "Pareto smoothed importance sampling", JMLR 25 (2024) 72.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

SMALLEST_TAIL = 5


def pareto_shape(exceedances: ArrayLike) -> float:
    """k̂ of values ≥ 0 above their threshold: the posterior mean of Zhang and Stephens, their weak prior of 0.5 worth ten
    values.
    """
    x = np.sort(np.asarray(exceedances, dtype=np.float64).ravel())
    n = x.size
    if n < SMALLEST_TAIL or x[-1] <= 0.0:
        return -math.inf if n and x[-1] <= 0.0 else math.nan
    count = 30 + int(math.sqrt(n))
    quartile = max(float(x[int(n / 4 + 0.5) - 1]), float(np.finfo(float).tiny))
    theta = 1.0 / x[-1] + (1.0 - np.sqrt(count / (np.arange(1, count + 1) - 0.5))) / (3.0 * quartile)
    shapes: NDArray[np.float64] = np.mean(np.log1p(-np.outer(theta, x)), axis=1)
    logs: NDArray[np.float64] = n * (np.log(-theta / shapes) - shapes - 1.0)
    weights = np.exp(logs - logs.max())
    best = float(np.sum(theta * weights) / weights.sum())
    return (n * float(np.mean(np.log1p(-best * x))) + 10 * 0.5) / (n + 10)


def tail_index(weights: ArrayLike) -> float:
    """k̂ of the largest weights; NaN where there are fewer than 25 weights, −∞ where the largest are all equal."""
    w = np.sort(np.asarray(weights, dtype=np.float64).ravel())
    size = int(min(w.size / 5, 3.0 * math.sqrt(w.size)))
    if size < SMALLEST_TAIL:
        return math.nan
    return pareto_shape(w[-size:] - w[-size - 1])
