"""First-order sensitivity from given data: the share of the variance of y that each input explains.

    S = Var(E[y | x]) / Var(y)

estimated over classes of x of equal size, less the share that classes explain by chance,

    S = 1 − (n − 1)/(n − m) · Σ (y − ȳ_class)² / Σ (y − ȳ)²          m classes

which is 0 on average if y does not depend on x (Fisher's adjusted correlation ratio ε²; T. Kelley, PNAS 21, 1935). Given-data
estimation of Sobol' indices: E. Plischke, E. Borgonovo, C. Smith, European J. Operational Research 226, 2013. Dependent
inputs share what they explain.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import invalid
from rvjax.stats.binomial import Estimate

RESAMPLES = 500


class Explained(NamedTuple):
    """share: S with the percentiles of its bootstrap. p: of the permutation test of "y does not depend on x"."""

    share: Estimate
    p: float


def explained(
    x: ArrayLike, y: ArrayLike, confidence: float = 0.95, *, rng: np.random.Generator, classes: int | None = None
) -> Explained:
    """The share of the variance of y that x explains. x, y: (n,). classes: about √n by default, at most 20.

    The interval is approximate, the permutation test is exact. ValueError unless x and y have the same size of 4 or more.
    """
    a, b = np.asarray(x, dtype=float).ravel(), np.asarray(y, dtype=float).ravel()
    n = a.size
    if n != b.size or n < 4:
        raise invalid("x and y must be pairs, 4 or more", f"{n} and {b.size} values")
    count = classes or min(20, max(2, math.isqrt(n)))
    labels = _classes(a, count)
    value = _share(labels, b)
    order = rng.permuted(np.tile(b, (RESAMPLES, 1)), axis=1)
    p = (1.0 + sum(_share(labels, permuted) >= value - 1e-12 for permuted in order)) / (RESAMPLES + 1.0)
    rows = rng.integers(n, size=(RESAMPLES, n))
    shares = [_share(_classes(a[row], count), b[row]) for row in rows]
    low, high = np.quantile(shares, [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0])
    method = f"given data, bootstrap of {RESAMPLES}, approximate"
    return Explained(Estimate(value, float(min(low, value)), float(max(high, value)), n, confidence, method), p)


def _classes(x: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """The class of each value: of equal size, equal values together."""
    cuts = np.unique(np.quantile(x, np.arange(1, count) / count, method="inverted_cdf"))
    return np.searchsorted(cuts, x, side="left")


def _share(labels: NDArray[np.int64], y: NDArray[np.float64]) -> float:
    total = float(np.sum((y - y.mean()) ** 2))
    sizes = np.bincount(labels)
    m, n = int(np.count_nonzero(sizes)), len(y)
    if total == 0.0 or n <= m:
        return 0.0
    means = np.bincount(labels, weights=y) / np.maximum(sizes, 1)
    return 1.0 - (n - 1.0) / (n - m) * float(np.sum((y - means[labels]) ** 2)) / total
