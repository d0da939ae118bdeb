"""Whether y depends on x at all, and how much of its variance x explains, from pairs that are there: by ranks of x.

    ξ = 1 − n Σ|r_(i+1) − r_i| / (2 Σ l_i (n − l_i)),   r_i = #{y_j ≤ y_i},  l_i = #{y_j ≥ y_i},  pairs in the order of x

ξ is about 0 if y does not depend on x and 1 if y is a function of x, whatever its form (S. Chatterjee, J. Am. Stat. Assoc. 116
(2021) 2009, with ties). Only ranks of y count, so an infinite value stands for a lost flight. If y does not depend on x, all
orders of y are equally probable:

    y of two values    n Σ|r_(i+1) − r_i| counts runs: its exact law (A. Wald & J. Wolfowitz, Ann. Math. Stat. 11 (1940) 147)
    ties below 10 %    normal with the exact variance (n − 2)(4n − 7)/(10 (n + 1)(n − 1)²) of values without ties
    ties above         permutations of y, the same for every x; beyond the last of them a Pearson III law with their moments
                       (P. Mielke & K. Berry, "Permutation Methods", 2nd ed., Springer, 2007, section 2.3), approximate

    S = 1 − ½ mean((y_(i+1) − y_i)²)/V,   V = mean((y − ȳ)²),  pairs in the order of x

estimates Var(E[y | x])/Var(y), the first-order Sobol index (F. Gamboa, P. Gremaud, T. Klein, A. Lagnoux, Bernoulli 28 (2022)
2345; there the first pair follows the last, whose x is far away). Equal values of x are put in a random order.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import invalid
from rvjax.stats.binomial import Estimate

TIED = 0.1
"""Share of values that equal another value, from which on ties change the null law too much for the one without ties."""

FEWEST_PERMUTATIONS, MOST_PERMUTATIONS, NUMBERS = 1_999, 99_999, 2 * 10**7
"""Of permutations: as many as permute NUMBERS values, within these limits."""

SEEN = 10
"""Permutations that must reach a value for their share to be its p-value."""

AT_ONCE = 10**6

Way = Literal["runs", "normal", "permutation"]


def order_of(x: ArrayLike, rng: np.random.Generator) -> NDArray[np.int64]:
    """(n,) places of the values in ascending order, equal values in a random order."""
    values = np.asarray(x, dtype=float).ravel()
    return np.lexsort((rng.random(values.size), values))


class Dependence:
    """ξ of one y with any number of x, and p-values that share a null law. y: (n,), n ≥ 4, infinities too, not NaN."""

    def __init__(self, y: ArrayLike, rng: np.random.Generator) -> None:
        values = np.asarray(y, dtype=float).ravel()
        if values.size < 4 or np.isnan(values).any():
            raise invalid("y must be 4 or more values, none of them NaN", f"{values.size} values")
        ascending = np.sort(values)
        self.n = values.size
        self._rank = np.searchsorted(ascending, values, side="right").astype(float)
        above = self.n - np.searchsorted(ascending, values, side="left").astype(float)
        self._scale = 2.0 * float(np.sum(above * (self.n - above))) / self.n
        _, sizes = np.unique(values, return_counts=True)
        self.distinct = len(sizes)
        self.tied = float(sizes[sizes > 1].sum()) / self.n
        """Share of the values that equal another value."""
        self._sizes, self._rng = sizes, rng
        self._table: NDArray[np.float64] | None = None

    @property
    def way(self) -> Way:
        """How p-values are computed."""
        return "runs" if self.distinct == 2 else "normal" if self.tied < TIED else "permutation"

    def xi(self, order: NDArray[np.int64]) -> float:
        """ξ with the x of this order (`order_of`); 0 if y does not vary."""
        return 1.0 - self._steps(self._rank[order]) / self._scale if self._scale else 0.0

    def p(self, xi: float) -> float:
        """P(ξ ≥ this value) if y does not depend on x."""
        if not self._scale:
            return 1.0
        if self.way == "runs":
            few = int(self._sizes.min())
            runs = round((1.0 - xi) * 2.0 * few * (self.n - few) / self.n) + 1
            return runs_cdf(runs, few, self.n - few)
        if self.way == "normal":
            n = self.n
            variance = (n - 2) * (4 * n - 7) / (10 * (n + 1) * (n - 1) ** 2)
            return float(scipy.special.ndtr(-xi / math.sqrt(variance)))
        return self._permuted_p(xi)

    @staticmethod
    def _steps(ranks: NDArray[np.float64]) -> float:
        return float(np.sum(np.abs(np.diff(ranks))))

    def _permuted_p(self, xi: float) -> float:
        table = self._null()
        reached = len(table) - int(np.searchsorted(table, xi - 1e-12))
        if reached >= SEEN:
            return (reached + 1.0) / (len(table) + 1.0)
        mean, sd = float(table.mean()), float(table.std())
        skew = float(np.mean((table - mean) ** 3)) / sd**3
        return min((reached + 1.0) / (len(table) + 1.0), _pearson_tail((xi - mean) / sd, skew))

    def _null(self) -> NDArray[np.float64]:
        """ξ of permutations of y, ascending."""
        if self._table is None:
            count = min(max(NUMBERS // self.n, FEWEST_PERMUTATIONS), MOST_PERMUTATIONS)
            rows = max(1, AT_ONCE // self.n)
            parts: list[NDArray[np.float64]] = []
            for first in range(0, count, rows):
                permuted = self._rng.permuted(np.tile(self._rank, (min(rows, count - first), 1)), axis=1)
                parts.append(1.0 - np.abs(np.diff(permuted, axis=1)).sum(axis=1) / self._scale)
            self._table = np.sort(np.concatenate(parts))
        return self._table


def runs_cdf(runs: int, few: int, many: int) -> float:
    """P(at most so many runs) in a random order of `few` values of a kind and `many` of another.

    P(R = 2k) = 2 C(f−1, k−1) C(m−1, k−1)/C(n, f),   P(R = 2k + 1) = [C(f−1, k) C(m−1, k−1) + C(f−1, k−1) C(m−1, k)]/C(n, f)
    """
    if few < 1 or many < 1:
        raise invalid("both kinds must be there", f"{few} and {many}")
    r = np.arange(2, min(runs, 2 * min(few, many) + 1) + 1)
    k = r // 2
    whole = _log_choose(few + many, few)
    even = math.log(2.0) + _log_choose(few - 1, k - 1) + _log_choose(many - 1, k - 1)
    odd = np.logaddexp(
        _log_choose(few - 1, k) + _log_choose(many - 1, k - 1), _log_choose(few - 1, k - 1) + _log_choose(many - 1, k)
    )
    return float(min(1.0, np.sum(np.exp(np.where(r % 2 == 0, even, odd) - whole))))


def _log_choose(n: int, k: NDArray[np.int64] | int) -> NDArray[np.float64]:
    """ln C(n, k), −∞ where k is outside 0..n."""
    count = np.asarray(k, dtype=float)
    inside = (count >= 0) & (count <= n)
    kept = np.where(inside, count, 0.0)
    value = -np.asarray(scipy.special.betaln(n - kept + 1.0, kept + 1.0)) - math.log(n + 1.0)
    chosen: NDArray[np.float64] = np.where(inside, value, -np.inf)
    return chosen


def _pearson_tail(z: float, skew: float) -> float:
    """P(Z ≥ z) of the Pearson III law with mean 0, variance 1 and this skewness; of the normal law if that is not above 0."""
    if skew < 1e-6:
        return float(scipy.special.ndtr(-z))
    shape = 4.0 / skew**2
    return float(scipy.special.gammaincc(shape, max(0.0, shape + z * math.sqrt(shape))))


class RankIndex(NamedTuple):
    """The first-order index and its standard error, approximate; both 0 if y does not vary."""

    value: float
    error: float


def rank_index(y: ArrayLike, order: NDArray[np.int64]) -> RankIndex:
    """First-order Sobol index of the x of this order, with its standard error. y: (n,), n ≥ 4, finite.

    With ψ_i = [(1 − S) v_i − ½(y_(i+1) − y_i)²]/V, v_i the mean of (y − ȳ)² of both, whose mean is 0, and its autocovariances γ
    in the order of x,

        Var S = (γ_0 + 2 (γ_1 − γ_2))/n

    ψ_i and ψ_(i+1) share y_(i+1), ψ_i and ψ_(i+2) only their x: γ_2 is what neighbours have in common through x alone.
    """
    values = np.asarray(y, dtype=float).ravel()[order]
    if values.size < 4 or not np.isfinite(values).all():
        raise invalid("y must be 4 or more finite values", f"{values.size} values")
    squares = (values - float(values.mean())) ** 2
    variance = float(squares.mean())
    if variance <= 0.0:
        return RankIndex(0.0, 0.0)
    apart, around = 0.5 * np.diff(values) ** 2, 0.5 * (squares[1:] + squares[:-1])
    around[[0, -1]] += 0.5 * squares[[0, -1]]  # each value counts once
    share, n = 1.0 - float(apart.mean()) / variance, values.size
    influence = ((1.0 - share) * around - apart) / variance
    covariances = [float(influence[: n - 1 - lag] @ influence[lag:]) / n for lag in range(3)]
    return RankIndex(share, math.sqrt(max(covariances[0] + 2.0 * (covariances[1] - covariances[2]), 0.0) / n))


def rank_sobol(x: ArrayLike, y: ArrayLike, confidence: float = 0.95, *, rng: np.random.Generator) -> Estimate:
    """The first-order Sobol index of x for y from pairs (n,), n ≥ 4, with its approximate interval. y: finite."""
    index = rank_index(y, order_of(x, rng))
    half = float(scipy.special.ndtri((1.0 + confidence) / 2.0)) * index.error
    n = np.asarray(y).size
    return Estimate(index.value, index.value - half, index.value + half, n, confidence, "rank estimate, normal, approximate")
