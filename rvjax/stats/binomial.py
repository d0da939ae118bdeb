"""Shares: exact bounds, smallest numbers of samples, and the chances of a verdict with a fixed number of samples.

Shares are pure numbers in [0, 1]. All functions are exact for every n and p, except `wilson` and `jeffreys`, which are for plots.

Sources: C. J. Clopper & E. S. Pearson, Biometrika 26 (1934) 404; S. S. Wilks, Ann. Math. Stat. 12 (1941) 91;
E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209; L. D. Brown, T. T. Cai & A. DasGupta, Stat. Sci. 16 (2001) 101.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, overload

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import binomial_cdf, check_share, invalid, largest, whole
from rvjax.stats.boundary_crossing import Boundary

Side = Literal["left", "right"]


@dataclass(frozen=True)
class Estimate:
    """A value and the interval [low, high] that covers the truth with probability >= confidence.

    The interval is two-sided unless `method` says one-sided: then each end by itself holds at `confidence`. An end that
    `n` values cannot support is infinite. `method` says "approximate" if the confidence is not guaranteed.
    """

    value: float
    low: float
    high: float
    n: int
    confidence: float
    method: str


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
    bound = np.where(k == 0, 0.0, scipy.special.betaincinv(some, size - k + 1, 1 - confidence))
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

    If `failures` of n samples fail, the share of successes is >= q at `confidence` (one-sided). With failures = 1 the
    smallest and the largest of n values also enclose a share q of all values.
    """
    check_share("q", q)
    check_share("confidence", confidence)
    enough = failures + 1
    while binomial_cdf(failures, enough, 1 - q) > 1 - confidence:
        enough *= 2
    return bisect_left(range(enough), True, key=lambda n: binomial_cdf(failures, n, 1 - q) <= 1 - confidence)


# --- verdicts with a fixed number of samples --------------------------------------------------------------------------


class Chances(NamedTuple):
    """The probability of each verdict; they add up to 1."""

    passes: NDArray[np.float64]
    fails: NDArray[np.float64]
    undecided: NDArray[np.float64]


def fixed_boundary(looks: ArrayLike, p0: float, confidence: float) -> Boundary:
    """PASS with at most f failures: P(X <= f) <= 1 - confidence; FAIL from f on: P(X >= f) < 1 - confidence; X ~ Bin(n, 1 - p0).

    PASS means lower bound >= p0, FAIL means upper bound < p0, both of Clopper and Pearson. Either is wrong with probability
    <= 1 - confidence at a single look; the errors of several looks add up (see `walk`). `looks`: numbers of samples.
    ValueError unless p0 and confidence are between 0 and 1.
    """
    check_share("p0", p0)
    check_share("confidence", confidence)
    n, risk = whole("looks", looks), 1 - confidence
    passes = largest(lambda k, size: binomial_cdf(k, size, 1 - p0) <= risk, n)
    successes = largest(lambda k, size: binomial_cdf(k, size, p0) < risk, n)
    return Boundary(n, passes, n - successes)


def verdict_chances(n: ArrayLike, p0: float, confidence: float, p: ArrayLike) -> Chances:
    """P(PASS), P(FAIL) and P(UNDECIDED) of the verdict of `fixed_boundary` with n samples that succeed with p; broadcasts n, p.

    For p >= p0 P(PASS) is the power and 1 - P(PASS) the producer's risk; for p < p0 P(PASS) <= 1 - confidence is the
    consumer's. ValueError unless 0 <= p <= 1.
    """
    share = np.asarray(p, dtype=float)
    if not np.all((share >= 0) & (share <= 1)):
        raise invalid("p must be between 0 and 1", p)
    size, most, least = fixed_boundary(n, p0, confidence)
    passes = binomial_cdf(most, size, 1 - share)
    fails = binomial_cdf(size - np.maximum(least, most + 1), size, share)
    return Chances(passes, fails, np.maximum(0, 1 - passes - fails))


# --- coverage and intervals for plots -----------------------------------------------------------------------------------


class Ends(NamedTuple):
    """Lower and upper ends of intervals."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]


def coverage(low: ArrayLike, high: ArrayLike, p: ArrayLike) -> NDArray[np.float64]:
    """sum of P(Bin(n, p) = k) over the k whose interval [low[k], high[k]] holds p, for every p.

    `low`, `high`: (n + 1,), neither falling with the number of successes k = 0..n; ValueError otherwise.
    """
    ends = _ends(low, high)
    return _accepted(ends, np.asarray(p, dtype=float), "left", "right")


def worst_coverage(low: ArrayLike, high: ArrayLike, least: float = 0.0, most: float = 1.0) -> float:
    """The infimum of `coverage` over least <= p <= most.

    Between neighbouring ends of intervals the set of k that hold p is the same run a..b, and P(a <= Bin(n, p) <= b) has no
    minimum inside: the infimum is a limit at an end (or `least`, `most`) from the left or right.
    """
    ends = _ends(low, high)
    points = np.unique(np.clip(np.concatenate([ends.low, ends.high, [least, most]]), least, most))
    at, after = _accepted(ends, points, "left", "right"), _accepted(ends, points[:-1], "right", "right")
    before = _accepted(ends, points[1:], "left", "left")
    return float(min(at.min(), after.min(initial=1), before.min(initial=1)))


def wilson(successes: ArrayLike, n: ArrayLike, confidence: float) -> Ends:
    """The p with |k/n - p| <= z sqrt(p (1 - p) / n), z the normal quantile of (1 + confidence) / 2. For plots only.

    Approximate: its coverage falls below the confidence. Broadcasts; without samples [0, 1]. Source: Wilson (1927).
    """
    k, size = _counts(successes, n, confidence)
    z2 = scipy.special.ndtri((1 + confidence) / 2) ** 2
    some = np.maximum(size, 1)
    centre, half = k + z2 / 2, np.sqrt(z2 * (k * (size - k) / some + z2 / 4))
    low = np.where(k == 0, 0.0, (centre - half) / (size + z2))
    return Ends(low, np.where(k == size, 1.0, (centre + half) / (size + z2)))


def jeffreys(successes: ArrayLike, n: ArrayLike, confidence: float) -> Ends:
    """Quantiles (1 -+ confidence) / 2 of Beta(k + 1/2, n - k + 1/2); 0 without a success, 1 without a failure. For plots only.

    Approximate: its coverage falls below the confidence. Broadcasts. Source: Brown, Cai & DasGupta (2001).
    """
    k, size = _counts(successes, n, confidence)
    low, high = (scipy.special.betaincinv(k + 0.5, size - k + 0.5, (1 + side * confidence) / 2) for side in (-1, 1))
    return Ends(np.where(k == 0, 0.0, low), np.where(k == size, 1.0, high))


# --- shared ---------------------------------------------------------------------------------------------------------


def _ends(low: ArrayLike, high: ArrayLike) -> Ends:
    ends = Ends(np.asarray(low, dtype=float), np.asarray(high, dtype=float))
    if ends.low.ndim != 1 or ends.low.shape != ends.high.shape or any(np.any(np.diff(end) < 0) for end in ends):
        raise ValueError("low and high must be rows of the same n + 1 numbers of successes, neither falling")
    return ends


def _accepted(ends: Ends, p: NDArray[np.float64], of_high: Side, of_low: Side) -> NDArray[np.float64]:
    """P(a <= Bin(n, p) <= b): from the first k with high >= p ("left"; > p: "right") to the last with low <= p ("right"; < p)."""
    n = ends.low.size - 1
    first, last = np.searchsorted(ends.high, p, of_high), np.searchsorted(ends.low, p, of_low) - 1
    return np.maximum(0, binomial_cdf(last, n, p) - binomial_cdf(first - 1, n, p))


def _counts(successes: ArrayLike, n: ArrayLike, confidence: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Successes and sizes, broadcast, 0 <= successes <= n."""
    check_share("confidence", confidence)
    k, size = np.broadcast_arrays(np.asarray(successes, dtype=float), np.asarray(n, dtype=float))
    if not np.all((k >= 0) & (k <= size)):
        raise invalid("successes must be between 0 and n", f"{successes} of {n}")
    return k, size
