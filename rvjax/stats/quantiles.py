"""Quantiles and whole distributions without any assumption on their shape: order statistics and a confidence band.

Results have the unit of the values. NaN counts as the worst value.

Sources: S. S. Wilks, Ann. Math. Stat. 12 (1941) 91; P. Massart, Ann. Probab. 18 (1990) 1269.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import binomial_cdf, check_share, ranked
from rvjax.stats.binomial import Estimate
from rvjax.stats.quantile_sketch import Sketch


def quantile_interval(values: ArrayLike | Sketch, q: float, confidence: float = 0.95, *, worst: float = math.inf) -> Estimate:
    """The q-quantile x_(ceil(n q)) with the order statistics x_(l), x_(u) that enclose the true quantile.

    Distribution-free, ties and infinities included: l is the largest with P(Bin(n, q) < l) <= (1 - confidence) / 2, u
    the smallest with P(Bin(n, q) >= u) <= (1 - confidence) / 2. An end that no order statistic attains is infinite.

    `values`: any shape, flattened, any unit. NaN counts as `worst` (+inf, or -inf where higher is better). Without
    values the value is NaN. For a sketch: the same ranks, each end moved outwards to the edge of its bucket, so the interval
    contains that of the numbers; up to 8192 numbers both are equal.
    """
    if isinstance(values, Sketch):
        method = "order statistics" if values.exact else "order statistics, ends widened to those of a bucket"
        n, low, value, high = values.n, values.low, values.value, values.high
    else:
        x = ranked(values, worst)
        method, n = "order statistics", x.size
        low = value = high = x.__getitem__
    side = (1 + confidence) / 2
    if not n:
        return Estimate(math.nan, -math.inf, math.inf, 0, confidence, method)
    from_end, behind = _upper_rank(n, 1 - q, side), _upper_rank(n, q, side)
    least = float(low(n - 1 - from_end)) if from_end < n else -math.inf
    most = float(high(behind)) if behind < n else math.inf
    return Estimate(float(value(quantile_rank(n, q))), least, most, n, confidence, method)


def quantile_rank(n: int, q: float) -> int:
    """ceil(n q) - 1: the rank, from 0, of the q-quantile of n numbers in ascending order; n >= 1."""
    return max(1, math.ceil(n * q - 1e-9)) - 1  # 1e-9 absorbs the rounding of n q


def upper_tolerance_bound(values: ArrayLike, q: float, confidence: float) -> float:
    """The smallest x_(u) with P(Bin(n, q) < u) >= confidence; +inf if n is too small.

    One-sided (Wilks): at `confidence`, a share >= q of all values is <= the bound. NaN counts as +inf.
    """
    return _upper_order_statistic(ranked(values, math.inf), q, confidence)


def lower_tolerance_bound(values: ArrayLike, q: float, confidence: float) -> float:
    """The mirror image of `upper_tolerance_bound`: a share >= q of all values is >= the bound; NaN counts as -inf."""
    return -upper_tolerance_bound(-np.asarray(values, dtype=float), q, confidence)


class Interval(NamedTuple):
    """Two ends, in the unit of the values."""

    low: float
    high: float


def tolerance_interval(values: ArrayLike, q: float, confidence: float) -> Interval:
    """[x_(m), x_(n+1-m)], m the largest with P(Bin(n, 1 - q) <= 2 m - 1) <= 1 - confidence; infinite if n is too small.

    Two-sided (Wilks): at `confidence`, a share >= q of all values lies in it. m = 1: from the smallest to the largest
    value, which needs wilks_smallest_n(q, confidence, failures=1) values. NaN counts as +inf.
    """
    check_share("q", q)
    check_share("confidence", confidence)
    x = ranked(values, math.inf)
    n = x.size
    enough = bisect_left(range(1, n // 2 + 1), True, key=lambda m: binomial_cdf(2 * m - 1, n, 1 - q) > 1 - confidence)
    return Interval(float(x[enough - 1]), float(x[n - enough])) if enough else Interval(-math.inf, math.inf)


# --- whole distributions --------------------------------------------------------------------------------------------


def dkw_band(n: int, confidence: float) -> float:
    """sqrt(ln(2 / (1 - confidence)) / (2 n)): half-width of the band around an empirical distribution function.

    At `confidence` the true distribution function lies in the band everywhere at once (Dvoretzky-Kiefer-Wolfowitz with
    Massart's constant). At most 1, as without samples.
    """
    check_share("confidence", confidence)
    return min(1.0, math.sqrt(math.log(2 / (1 - confidence)) / (2 * n))) if n else 1.0


# --- ranks ----------------------------------------------------------------------------------------------------------


def _upper_order_statistic(x: NDArray[np.float64], q: float, confidence: float) -> float:
    """The smallest x_(u), u = 1..n, with P(Bin(n, q) <= u - 1) >= confidence; +inf if there is none."""
    below = _upper_rank(x.size, q, confidence)
    return float(x[below]) if below < x.size else math.inf


def _upper_rank(n: int, q: float, confidence: float) -> int:
    """The smallest k with P(Bin(n, q) <= k) >= confidence, the rank of an order statistic from 0; n if there is none."""
    check_share("q", q)
    check_share("confidence", confidence)
    return bisect_left(range(n), True, key=lambda k: bool(binomial_cdf(k, n, q) >= confidence))
