"""Samples of a law as samples of another law: by thinning, exactly, or by weights, approximately.

    w_i = f'(x_i)/f(x_i),   W = sup w, from the laws

    thinning           sample i is kept iff v_i < w_i/W, v_i uniform by itself: the kept are independent samples of f'
    self-normalised    p̂ = Σ w y/Σ w,   effective sample size (Σ w)²/Σ w²
    control variate    p̂ = mean(w y) − β (mean(w) − 1),   β = Cov(w y, w)/Var(w): uses that the mean of w is 1

A law that reaches beyond f with probability q gives p only between p_c (1 − q) and p_c (1 − q) + q, p_c: of the law within f.

The shape k̂ of the tail of the weights, fitted to the largest 3 √n of them, tells whether weights can be averaged: above 0.7 not
(A. Vehtari, D. Simpson, A. Gelman, Y. Yao, J. Gabry, J. Machine Learning Research 25 (2024) 72; fit: J. Zhang & M. Stephens,
Technometrics 51 (2009) 316).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import check_share, invalid
from rvjax.stats.binomial import Estimate, clopper_pearson

Values = NDArray[np.float64]

FEWEST_KEPT = 59
"""Kept samples: with fewer, not even all of them complying shows 95 % at 95 %."""

FEWEST_EFFECTIVE, LARGEST_SHARE, LARGEST_K = 100.0, 0.01, 0.7
"""Limits beyond which weights are refused: effective sample size, share of a weight, shape of the tail."""

MOST_BEYOND = 0.05
"""Probability beyond the old law up to which an interval is given."""

CLOSE = 1e-9


def kept(log_w: ArrayLike, log_sup: float, v: ArrayLike) -> NDArray[np.bool_]:
    """(n,) which samples thinning keeps: v < w/W. log_w: ln w, −∞ where f' is 0; log_sup: ln W; v: (n,) in (0, 1).

    Exact: a kept sample has the law f' whatever W ≥ sup w is. ValueError where a weight is above W.
    """
    weights = np.asarray(log_w, dtype=float)
    if not math.isfinite(log_sup):
        raise invalid("the supremum of the weights must be finite", log_sup)
    if weights.size and float(weights.max()) > log_sup + CLOSE:
        raise invalid("no weight may be above the supremum", f"{float(weights.max())} > {log_sup}")
    return np.log(np.asarray(v, dtype=float)) < weights - log_sup


class WeightQuality(NamedTuple):
    """effective: sample size; largest: the largest weight as a share of the sum; k: shape of the tail."""

    effective: float
    largest: float
    k: float

    def complaints(self) -> list[str]:
        """What keeps the weights from being averaged, in words; empty where nothing does."""
        found: list[str] = []
        if not self.effective >= FEWEST_EFFECTIVE:
            found.append(f"an effective sample size of {self.effective:.1f}, below {FEWEST_EFFECTIVE:g}")
        if self.largest > LARGEST_SHARE:
            found.append(f"a weight that is {100 * self.largest:.2g} % of their sum, above {100 * LARGEST_SHARE:g} %")
        if self.k > LARGEST_K:
            found.append(f"a tail of the weights of shape {self.k:.2f}, above {LARGEST_K:g}")
        return found


def quality(w: ArrayLike) -> WeightQuality:
    """The quality of weights (n,), all ≥ 0; (0, 1, ∞) without a weight above 0."""
    weights = np.asarray(w, dtype=float).ravel()
    total = float(weights.sum())
    if not total > 0.0:
        return WeightQuality(0.0, 1.0, math.inf)
    return WeightQuality(total**2 / float(np.sum(weights**2)), float(weights.max()) / total, tail_shape(weights))


def tail_shape(w: ArrayLike) -> float:
    """k̂ of the generalised Pareto law of the largest min(n/5, 3 √n) weights over the next smaller; −∞ where they are equal."""
    ascending = np.sort(np.asarray(w, dtype=float).ravel())
    count = min(len(ascending) // 5, math.ceil(3.0 * math.sqrt(len(ascending))))
    if count < 5:
        return math.inf
    excess = ascending[-count:] - ascending[-count - 1]
    if excess[-1] <= CLOSE * ascending[-1]:
        return -math.inf
    excess = excess[excess > 0.0]
    return _pareto_shape(excess) if len(excess) >= 5 else math.inf


def _pareto_shape(x: Values) -> float:
    """k of G(x) = 1 − (1 + k x/σ)^(−1/k) by Zhang and Stephens' weighted mean over θ = −k/σ. x: ascending, above 0."""
    n = len(x)
    m = 30 + math.isqrt(n)
    quarter = float(x[int(n / 4.0 + 0.5) - 1])
    theta = 1.0 / x[-1] + (1.0 - np.sqrt(m / (np.arange(1, m + 1) - 0.5))) / (3.0 * quarter)
    shapes = np.mean(np.log1p(-theta[:, None] * x), axis=1)
    likelihood = n * (np.log(-theta / shapes) - shapes - 1.0)
    weights = 1.0 / np.sum(np.exp(likelihood[None] - likelihood[:, None]), axis=1)
    best = float(np.sum(theta * weights) / weights.sum())
    shape = float(np.mean(np.log1p(-best * x)))
    return (n * shape + 5.0) / (n + 10.0)


def self_normalised(w: ArrayLike, y: ArrayLike, confidence: float = 0.95) -> Estimate:
    """Σ w y/Σ w with a normal interval by the delta method, nominal. w, y: (n,), w ≥ 0, not all 0."""
    weights, values = _pairs(w, y)
    share = float(np.sum(weights * values) / weights.sum())
    error = float(np.sqrt(np.sum((weights * (values - share)) ** 2))) / float(weights.sum())
    return _normal(share, error, len(values), confidence, "self-normalised weights, nominal")


def control_variate(w: ArrayLike, y: ArrayLike, confidence: float = 0.95) -> Estimate:
    """mean(w y) − β (mean(w) − 1) with a normal interval, nominal. For laws that lie within the old ones, where E w = 1."""
    weights, values = _pairs(w, y)
    product = weights * values
    spread = float(np.var(weights))
    beta = float(np.mean((weights - float(weights.mean())) * product)) / spread if spread > 0.0 else 0.0
    share = float(product.mean()) - beta * (float(weights.mean()) - 1.0)
    error = float(np.std(product - beta * weights)) / math.sqrt(len(values))
    return _normal(share, error, len(values), confidence, "weights with their mean as control variate, nominal")


def _pairs(w: ArrayLike, y: ArrayLike) -> tuple[Values, Values]:
    weights, values = np.asarray(w, dtype=float).ravel(), np.asarray(y, dtype=float).ravel()
    if weights.size != values.size or weights.size < 2 or not weights.sum() > 0.0 or weights.min() < 0.0:
        raise invalid("weights and values must be pairs, 2 or more, with weights of 0 or more, not all 0", f"{weights.size}")
    return weights, values


def _normal(value: float, error: float, n: int, confidence: float, method: str) -> Estimate:
    check_share("confidence", confidence)
    half = float(scipy.special.ndtri((1.0 + confidence) / 2.0)) * error
    return Estimate(value, value - half, value + half, n, confidence, method)


def with_the_rest(inside: Estimate, beyond: float) -> Estimate:
    """The share p of a law of which a part q lies beyond the samples: low (1 − q) to high (1 − q) + q. inside: p_c."""
    if not 0.0 <= beyond <= MOST_BEYOND:
        raise invalid(f"the probability beyond must be 0 to {MOST_BEYOND}", beyond)
    within = 1.0 - beyond
    low, high = inside.low * within, inside.high * within + beyond
    middle = inside.value * within + 0.5 * beyond
    return Estimate(middle, low, high, inside.n, inside.confidence, f"{inside.method}, with nothing known beyond")


class Class(NamedTuple):
    """Samples whose draw lies in [low, high]; share: of them with a property, and its interval."""

    low: float
    high: float
    share: Estimate


def shares_of_classes(x: ArrayLike, y: ArrayLike, classes: int, confidence: float = 0.95) -> list[Class]:
    """P(y | class of x) with Clopper-Pearson intervals that hold for all classes together (Bonferroni): exact given the x.

    Classes of equal size, equal values together. x: (n,), infinities too; y: (n,) bool. Fewer classes where values are equal.
    """
    values, marks = np.asarray(x, dtype=float).ravel(), np.asarray(y, dtype=bool).ravel()
    if values.size != marks.size or not values.size or classes < 1:
        raise invalid("x and y must be pairs, in 1 class or more", f"{values.size} and {marks.size} values")
    cuts = np.unique(np.quantile(values, np.arange(1, classes) / classes, method="inverted_cdf"))
    labels = np.searchsorted(cuts, values, side="left")
    present = np.unique(labels)
    each = 1.0 - (1.0 - confidence) / len(present)
    found: list[Class] = []
    for label in present:
        chosen = labels == label
        of_class = values[chosen]
        share = clopper_pearson(int(np.count_nonzero(marks[chosen])), len(of_class), each)
        found.append(Class(float(of_class.min()), float(of_class.max()), share))
    return found
