"""Bounds that hold at their stated confidence for every sample size: binomial shares, quantiles, whole distributions.

Nothing here assumes a shape of the distribution, and nothing but `mean_interval` is approximate. Shares are pure
numbers in [0, 1]; values keep the unit they come with. A value that is not a number counts as the worst one.

Sources: C. J. Clopper & E. S. Pearson, Biometrika 26 (1934) 404; S. S. Wilks, Ann. Math. Stat. 12 (1941) 91;
P. Massart, Ann. Probab. 18 (1990) 1269; B. Efron, J. Am. Stat. Assoc. 82 (1987) 171.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special  # pyright: ignore[reportMissingTypeStubs]

from rvjax.sketch import Sketch

RESAMPLES = 2000
"""Bootstrap samples behind `mean_interval`."""


@dataclass(frozen=True)
class Estimate:
    """A value and the interval [low, high] that covers the truth with probability >= confidence.

    The interval is two-sided unless `method` says one-sided: then each end alone holds at `confidence`. An end that
    `n` values cannot support is infinite. `method` says "approximate" where the confidence is not guaranteed.
    """

    value: float
    low: float
    high: float
    n: int
    confidence: float
    method: str


# --- shares ---------------------------------------------------------------------------------------------------------


@overload
def clopper_pearson_lower(successes: float, n: float, confidence: float) -> float: ...
@overload
def clopper_pearson_lower(successes: NDArray[Any], n: ArrayLike, confidence: float) -> NDArray[np.float64]: ...
def clopper_pearson_lower(successes: ArrayLike, n: ArrayLike, confidence: float) -> float | NDArray[np.float64]:
    """The p at which P(Bin(n, p) >= successes) = 1 - confidence; 0 without a success.

    One-sided: P(bound <= true p) >= confidence for every p and n. Broadcasts over `successes` and `n`.
    """
    k, size = _counts(successes, n, confidence)
    some = np.maximum(k, np.finfo(float).tiny)  # betaincinv has no value at 0 successes; the bound there is set below
    bound = np.where(k == 0, 0.0, special.betaincinv(some, size - k + 1, 1 - confidence))
    return float(bound) if bound.ndim == 0 else bound


@overload
def clopper_pearson_upper(successes: float, n: float, confidence: float) -> float: ...
@overload
def clopper_pearson_upper(successes: NDArray[Any], n: ArrayLike, confidence: float) -> NDArray[np.float64]: ...
def clopper_pearson_upper(successes: ArrayLike, n: ArrayLike, confidence: float) -> float | NDArray[np.float64]:
    """The p at which P(Bin(n, p) <= successes) = 1 - confidence; 1 without a failure.

    One-sided: P(bound >= true p) >= confidence for every p and n. Broadcasts over `successes` and `n`.
    """
    k, size = _counts(successes, n, confidence)
    bound = 1 - np.asarray(clopper_pearson_lower(np.asarray(size - k), size, confidence))
    return float(bound) if bound.ndim == 0 else bound


def clopper_pearson(successes: int, n: int, confidence: float = 0.95) -> Estimate:
    """Successes / n with the two-sided Clopper-Pearson interval: each end one-sided at (1 + confidence) / 2.

    Without samples the value is NaN and the interval [0, 1].
    """
    side = (1 + confidence) / 2
    low, high = clopper_pearson_lower(successes, n, side), clopper_pearson_upper(successes, n, side)
    return Estimate(successes / n if n else math.nan, low, high, n, confidence, "Clopper-Pearson")


def wilks_smallest_n(q: float, confidence: float, failures: int = 0) -> int:
    """The smallest n with P(Bin(n, 1 - q) <= failures) <= 1 - confidence.

    With so many samples, `failures` of them bad, the share of good ones is >= q at `confidence` (one-sided). With
    failures = 1 it is also the n whose smallest and largest value enclose a share q of all values.
    """
    _check_share("q", q)
    _check_share("confidence", confidence)
    enough = failures + 1
    while _binomial_cdf(failures, enough, 1 - q) > 1 - confidence:
        enough *= 2
    return bisect_left(range(enough), True, key=lambda n: _binomial_cdf(failures, n, 1 - q) <= 1 - confidence)


# --- quantiles ------------------------------------------------------------------------------------------------------


def quantile_interval(values: ArrayLike | Sketch, q: float, confidence: float = 0.95, *, worst: float = math.inf) -> Estimate:
    """The q-quantile x_(ceil(n q)) with the order statistics x_(l), x_(u) that enclose the true one.

    Distribution-free, ties and infinities included: l is the largest with P(Bin(n, q) < l) <= (1 - confidence) / 2, u
    the smallest with P(Bin(n, q) >= u) <= (1 - confidence) / 2. An end that no order statistic attains is infinite.

    `values`: any shape, flattened, any unit. NaN counts as `worst` (+inf, or -inf where higher is better). Without
    values the value is NaN. Of a sketch: the same ranks, each end moved outwards to the edge of its bucket, so that the
    interval holds that of the numbers themselves; up to 8192 numbers it is that interval.
    """
    if isinstance(values, Sketch):
        method = "order statistics" if values.exact else "order statistics, ends widened to those of a bucket"
        n, low, value, high = values.n, values.low, values.value, values.high
    else:
        ranked = _ranked(values, worst)
        method, n = "order statistics", ranked.size
        low = value = high = ranked.__getitem__
    side = (1 + confidence) / 2
    if not n:
        return Estimate(math.nan, -math.inf, math.inf, 0, confidence, method)
    from_end, behind = _upper_rank(n, 1 - q, side), _upper_rank(n, q, side)
    least = float(low(n - 1 - from_end)) if from_end < n else -math.inf
    most = float(high(behind)) if behind < n else math.inf
    return Estimate(float(value(quantile_rank(n, q))), least, most, n, confidence, method)


def quantile_rank(n: int, q: float) -> int:
    """ceil(n q) - 1: which of n numbers in ascending order, from 0, is their q-quantile; n >= 1."""
    return max(1, math.ceil(n * q - 1e-9)) - 1  # 1e-9 forgives the rounding of n q


def upper_tolerance_bound(values: ArrayLike, q: float, confidence: float) -> float:
    """The smallest x_(u) with P(Bin(n, q) < u) >= confidence; +inf where n is too small.

    One-sided (Wilks): at `confidence`, a share >= q of all values is <= the bound. NaN counts as +inf.
    """
    return _upper_order_statistic(_ranked(values, math.inf), q, confidence)


def lower_tolerance_bound(values: ArrayLike, q: float, confidence: float) -> float:
    """The mirror image of `upper_tolerance_bound`: a share >= q of all values is >= the bound; NaN counts as -inf."""
    return -upper_tolerance_bound(-np.asarray(values, dtype=float), q, confidence)


# --- whole distributions and means ----------------------------------------------------------------------------------


def dkw_band(n: int, confidence: float) -> float:
    """sqrt(ln(2 / (1 - confidence)) / (2 n)): half-width of the band around an empirical distribution function.

    At `confidence` the true distribution function lies in the band everywhere at once (Dvoretzky-Kiefer-Wolfowitz with
    Massart's constant). At most 1, as without samples.
    """
    _check_share("confidence", confidence)
    return min(1.0, math.sqrt(math.log(2 / (1 - confidence)) / (2 * n))) if n else 1.0


def mean_interval(values: ArrayLike, confidence: float = 0.95) -> Estimate:
    """The mean with its BCa bootstrap interval: approximate, for smooth summaries only, never for a verdict.

    The resampling generator is fixed, so that the same values always give the same interval. One value that is not
    finite makes the mean infinite; fewer than two values have the interval (-inf, inf).
    """
    x = _ranked(values, math.inf)
    method = f"BCa bootstrap, approximate, {RESAMPLES} resamples"
    mean = float(x.mean()) if x.size else math.nan
    if not np.isfinite(x).all():
        return Estimate(mean, mean, mean, x.size, confidence, method)
    if x.size < 2:
        return Estimate(mean, -math.inf, math.inf, x.size, confidence, method)
    deviation = x - mean
    spread = float(np.sum(deviation**2))
    if spread == 0:
        return Estimate(mean, mean, mean, x.size, confidence, method)
    generator = np.random.Generator(np.random.Philox(key=0))
    means = np.array([x[generator.integers(x.size, size=x.size)].mean() for _ in range(RESAMPLES)])
    below = np.count_nonzero(means < mean) + np.count_nonzero(means == mean) / 2
    bias: float = special.ndtri(min(max(below, 1), RESAMPLES - 1) / RESAMPLES)
    acceleration = float(np.sum(deviation**3)) / (6 * spread**1.5)
    shifted = bias + special.ndtri(np.array([1 - confidence, 1 + confidence]) / 2)
    low, high = np.quantile(means, special.ndtr(bias + shifted / (1 - acceleration * shifted)))
    return Estimate(mean, min(float(low), mean), max(float(high), mean), x.size, confidence, method)


# --- shared ---------------------------------------------------------------------------------------------------------


def _binomial_cdf(k: int, n: int, p: float) -> float:
    """P(Bin(n, p) <= k) = I_{1-p}(n - k, k + 1), for any k."""
    if k < 0 or k >= n:
        return float(k >= 0)
    return float(special.betainc(n - k, k + 1, 1 - p))


def _upper_order_statistic(ranked: NDArray[np.float64], q: float, confidence: float) -> float:
    """The smallest x_(u), u = 1..n, with P(Bin(n, q) <= u - 1) >= confidence; +inf if there is none."""
    below = _upper_rank(ranked.size, q, confidence)
    return float(ranked[below]) if below < ranked.size else math.inf


def _upper_rank(n: int, q: float, confidence: float) -> int:
    """The smallest k with P(Bin(n, q) <= k) >= confidence, the rank of an order statistic from 0; n if there is none."""
    _check_share("q", q)
    _check_share("confidence", confidence)
    return bisect_left(range(n), True, key=lambda k: _binomial_cdf(k, n, q) >= confidence)


def _ranked(values: ArrayLike, worst: float) -> NDArray[np.float64]:
    """The values in ascending order, NaN replaced by the worst."""
    x = np.asarray(values, dtype=float).ravel()
    return np.sort(np.where(np.isnan(x), worst, x))


def _counts(successes: ArrayLike, n: ArrayLike, confidence: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Successes and sizes, broadcast, 0 <= successes <= n."""
    _check_share("confidence", confidence)
    k, size = np.broadcast_arrays(np.asarray(successes, dtype=float), np.asarray(n, dtype=float))
    if not np.all((k >= 0) & (k <= size)):
        raise ValueError(f"successes must be between 0 and n; found {successes} of {n}")
    return k, size


def _check_share(name: str, value: float) -> None:
    if not 0 < value < 1:
        raise ValueError(f"{name} must be between 0 and 1, both excluded; found {value}")
