"""Sobol indices of groups of inputs from flights of their own: pick-freeze.

    rows i = 1..n:  a = f(A_i),  b = f(B_i),  c = f(A_i with group g from B_i)         n (G + 2) values for G groups

    S_g = ρ(b, c)       first order: b and c share group g alone
    T_g = 1 − ρ(a, c) = ½ E(a − c)²/V    total: a and c share all but group g (M. Jansen, Computer Physics Comm. 117, 1999)

    ρ(y, z) = Σ (y − m)(z − m)/½ Σ [(y − m)² + (z − m)²],   m = mean of y and z

which no other estimator of the same rows beats asymptotically (A. Janon, T. Klein, A. Lagnoux, M. Nodet, C. Prieur, ESAIM:
Probability and Statistics 18 (2014) 342). Delta method: ψ_i = [(y − m)(z − m) − ρ ½((y − m)² + (z − m)²)]_i/V has mean 0, and the
standard error is sd(ψ)/√n. Groups must be independent of each other, so draws that are correlated belong to one group. Then
S_g ≤ Shapley effect of g ≤ T_g (A. Owen, SIAM/ASA J. Uncertainty Quantification 2 (2014) 245).

An indicator that is seldom 1 has too few rows in which both of a pair are 1 for the delta method. With q = P(both | any) and
u = P(any), s = (1 + q)/2,

    ρ = (q − s² u)/(s − s² u)

rises with q and falls with u; q and u have Clopper-Pearson bounds, so the interval of ρ is exact.

A function of time has the indices Σ_t Cov_t/Σ_t V_t (F. Gamboa, A. Janon, T. Klein, A. Lagnoux, Electronic J. Statistics 8
(2014) 575).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import check_share, invalid
from rvjax.stats.binomial import Estimate, clopper_pearson

Values = NDArray[np.float64]

RESAMPLES = 400
APART = 1.25
"""Ratio of the standard errors by the bootstrap and by the delta method above which the larger one is taken."""


class Correlated(NamedTuple):
    """ρ with its standard errors by the delta method and by a bootstrap over rows."""

    value: float
    error: float
    resampled: float

    @property
    def wider(self) -> float:
        """The error by the delta method, or that of the bootstrap where it is much larger."""
        return self.resampled if self.resampled > APART * self.error else self.error


@dataclass(frozen=True)
class GroupIndices:
    """first, total: indices with intervals that hold for all groups together. checked: whether both of their errors agree with
    the bootstrap. low, high: the bracket of Shapley's effect. n: rows; left_out: share of the rows that had no finite value."""

    first: Estimate
    total: Estimate
    checked: bool
    low: float
    high: float
    n: int
    left_out: float


def correlation(y: ArrayLike, z: ArrayLike, rng: np.random.Generator, resamples: int = RESAMPLES) -> Correlated:
    """ρ(y, z). y, z: (n,) or, for functions of time, (n, times), finite; n ≥ 2. Without variation ρ = 1 where y = z."""
    given = [np.asarray(x, dtype=float) for x in (y, z)]
    first, second = (x.reshape(x.shape[0], -1) for x in given)
    if first.shape != second.shape or len(first) < 2:
        raise invalid("y and z must have the same shape, 2 rows or more", f"{first.shape} and {second.shape}")
    middle = 0.5 * (first.mean(axis=0) + second.mean(axis=0))
    common = np.sum((first - middle) * (second - middle), axis=1)
    square = 0.5 * np.sum((first - middle) ** 2 + (second - middle) ** 2, axis=1)
    if not square.any():
        return Correlated(1.0, 0.0, 0.0)
    n = len(common)
    value = float(common.sum() / square.sum())
    error = float(np.std((common - value * square) / square.mean())) / math.sqrt(n)
    if resamples <= 0 or np.array_equal(common, square):  # y = z in every row
        return Correlated(value, error, error)
    weights = rng.multinomial(n, np.full(n, 1.0 / n), size=resamples)
    below = weights @ square
    shares = (weights @ common)[below > 0.0] / below[below > 0.0]
    return Correlated(value, error, float(np.std(shares)))


def of_marks(y: ArrayLike, z: ArrayLike, confidence: float) -> Estimate:
    """ρ of two indicators with its exact two-sided interval. y, z: (n,) of 0 and 1. Without any 1, ρ is 1 and from −1 to 1."""
    one, two = np.asarray(y, dtype=bool), np.asarray(z, dtype=bool)
    n, any_, both = len(one), int(np.count_nonzero(one | two)), int(np.count_nonzero(one & two))
    level = (1.0 + confidence) / 2.0  # half of the risk for each of q and u
    q, u = clopper_pearson(both, any_, level), clopper_pearson(any_, n, level)

    def rho(q: float, u: float) -> float:
        s = 0.5 * (1.0 + q)
        return 1.0 if q >= 1.0 else (q - s * s * u) / (s - s * s * u)

    value = rho(q.value, u.value) if any_ else 1.0
    return Estimate(value, rho(q.low, u.high), rho(q.high, u.low), n, confidence, "pick-freeze, Clopper-Pearson, simultaneous")


def indices(
    a: ArrayLike,
    b: ArrayLike,
    swapped: Mapping[str, ArrayLike],
    confidence: float = 0.95,
    *,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> dict[str, GroupIndices]:
    """The indices of each group. a, b: (n,) or (n, times); swapped: c of each group, of the same shape.

    A row counts for a group only if a, b and its c are finite; `left_out` is the share of the others. Intervals hold together for
    all groups and both indices (Bonferroni): exactly for indicators, of 0 and 1 alone, approximately for all other values. Fewer
    than 4 rows: values NaN, intervals without ends.
    """
    check_share("confidence", confidence)
    one, two = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    parts = {name: np.asarray(c, dtype=float) for name, c in swapped.items()}
    each = 1.0 - (1.0 - confidence) / (2.0 * max(1, len(parts)))
    marks = one.ndim == 1 and all(np.isin(part, (0.0, 1.0)).all() for part in (one, two, *parts.values()))
    return {name: _of_group(one, two, c, each, marks, rng, resamples) for name, c in parts.items()}


def _of_group(
    a: Values, b: Values, c: Values, each: float, marks: bool, rng: np.random.Generator, resamples: int
) -> GroupIndices:
    """each: the confidence of each interval; marks: whether all values of all groups are 0 or 1."""
    finite = np.isfinite(np.stack([a, b, c])).all(axis=(0, *range(2, a.ndim + 1)))
    n, left_out = int(np.count_nonzero(finite)), 1.0 - float(np.mean(finite)) if finite.size else 1.0
    if n < 4:
        none = Estimate(math.nan, -math.inf, math.inf, n, each, "pick-freeze: too few rows")
        return GroupIndices(none, none, False, -math.inf, math.inf, n, left_out)
    if marks:
        first, kept = of_marks(b, c, each), of_marks(a, c, each)
        total = Estimate(1.0 - kept.value, 1.0 - kept.high, 1.0 - kept.low, n, each, kept.method)
        return GroupIndices(first, total, True, max(0.0, first.low), min(1.0, total.high), n, left_out)
    shared, rest = (correlation(x[finite], c[finite], rng, resamples) for x in (b, a))
    first, total = _normal(shared.value, shared.wider, n, each), _normal(1.0 - rest.value, rest.wider, n, each)
    checked = all(part.wider == part.error for part in (shared, rest))
    return GroupIndices(first, total, checked, max(0.0, first.low), min(1.0, total.high), n, left_out)


def _normal(value: float, error: float, n: int, each: float) -> Estimate:
    half = float(scipy.special.ndtri((1.0 + each) / 2.0)) * error
    return Estimate(value, value - half, value + half, n, each, "pick-freeze, delta method, simultaneous, approximate")


def ranks(a: ArrayLike, b: ArrayLike, swapped: Mapping[str, ArrayLike]) -> tuple[Values, Values, dict[str, Values]]:
    """The mid-ranks of all values together, as shares of 1, in the same form. Not NaN; infinite values are the lost flights."""
    parts = [np.asarray(x, dtype=float) for x in (a, b, *swapped.values())]
    together = np.concatenate([part.ravel() for part in parts])
    if np.isnan(together).any():
        raise invalid("a lost flight must be an infinite value", "NaN")
    ascending = np.sort(together)
    below, upto = (np.searchsorted(ascending, together, side=side) for side in ("left", "right"))
    scores = np.split((below + upto) / (2.0 * len(together)), np.cumsum([part.size for part in parts])[:-1])
    shaped = [score.reshape(part.shape) for score, part in zip(scores, parts, strict=True)]
    return shaped[0], shaped[1], dict(zip(swapped, shaped[2:], strict=True))


def most_that_matter(unchanged: int, n: int, confidence: float = 0.95) -> float | None:
    """1 − α^{1/n}: the largest share of flights in which a group matters that changed no bit of any of n flights; None if it
    changed one. Exact: if it mattered in more, all n would have missed it with probability below α."""
    return 1.0 - (1.0 - confidence) ** (1.0 / n) if n and unchanged == n else None


class OverTime(NamedTuple):
    """Of each bin of time: the first-order and total index of a group, NaN where nothing varies. first, total: over all bins."""

    first_of: Values
    total_of: Values
    first: float
    total: float


@dataclass
class RunningSums:
    """The sums of a pair of functions of time, so that no row needs to be kept: Σy, Σz, Σy², Σz², Σyz of each bin."""

    bins: int

    def __post_init__(self) -> None:
        self.n = np.zeros(self.bins)
        self.sums = np.zeros((5, self.bins))

    def add(self, y: Values, z: Values) -> None:
        """Adds rows (rows, bins). A bin of a row that is not finite in both is left out."""
        finite = np.isfinite(y) & np.isfinite(z)
        one, two = np.where(finite, y, 0.0), np.where(finite, z, 0.0)
        self.n += finite.sum(axis=0)
        self.sums += np.stack([part.sum(axis=0) for part in (one, two, one * one, two * two, one * two)])

    def moments(self) -> tuple[Values, Values]:
        """(bins,) Cov and V of ρ = Cov/V; 0 in a bin without rows."""
        n = np.maximum(self.n, 1.0)
        y, z, yy, zz, yz = self.sums / n
        middle = 0.5 * (y + z)
        return yz - middle**2, 0.5 * (yy + zz) - middle**2


def over_time(shared: RunningSums, kept: RunningSums) -> OverTime:
    """The indices of a group. shared: sums of b and c; kept: sums of a and c."""
    (cov_s, var_s), (cov_k, var_k) = shared.moments(), kept.moments()
    with np.errstate(invalid="ignore", divide="ignore"):
        curves = [np.where(var > 0.0, cov / var, math.nan) for cov, var in ((cov_s, var_s), (cov_k, var_k))]
        whole = [float(cov.sum() / var.sum()) if var.sum() > 0.0 else math.nan for cov, var in ((cov_s, var_s), (cov_k, var_k))]
    return OverTime(curves[0], 1.0 - curves[1], whole[0], 1.0 - whole[1])
