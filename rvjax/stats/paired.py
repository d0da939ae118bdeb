"""Two designs flown on the same draws: which is better, by how much, and whether A is not worse than B.

Of n pairs `both` succeed under A and B, `only_a` under A only, `only_b` under B only, `neither` under none. Only `only_a` and
`only_b` tell the designs apart. The difference is always P(A succeeds) - P(B succeeds), a pure number.

Sources: Q. McNemar, Psychometrika 12 (1947) 153; M. W. Fagerland, S. Lydersen & P. Laake, BMC Med. Res. Methodol. 13 (2013)
91 (mid-p); R. G. Newcombe, Stat. Med. 17 (1998) 2635; T. Tango, Stat. Med. 17 (1998) 891; H. Robbins, Ann. Math. Stat. 41
(1970) 1397 (mixtures).
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import binomial_cdf, check_share, invalid, whole
from rvjax.stats.binomial import Estimate, wilson

Better = Literal["either", "a", "b"]
"""The design that is better under the alternative."""

HALVINGS = 60
"""Bisections of an interval of length 2 that find an end to the last digit."""


class Pairs(NamedTuple):
    """Numbers of pairs by which designs succeeded."""

    both: int
    only_a: int
    only_b: int
    neither: int

    @property
    def n(self) -> int:
        """All pairs."""
        return self.both + self.only_a + self.only_b + self.neither


def pairs_of(a: ArrayLike, b: ArrayLike) -> Pairs:
    """How many pairs fall in each of the four cells, from two rows of successes (true or false) of the same draws."""
    first, second = np.asarray(a, dtype=bool), np.asarray(b, dtype=bool)
    if first.shape != second.shape:
        raise invalid("a and b must have the same shape", f"{first.shape} and {second.shape}")
    cells = (first & second, first & ~second, ~first & second, ~first & ~second)
    return Pairs(*(int(np.count_nonzero(cell)) for cell in cells))


def mcnemar(only_a: ArrayLike, only_b: ArrayLike, *, better: Better = "either", mid: bool = False) -> NDArray[np.float64]:
    """min(1, 2 P(X <= min(b, c))), X ~ Bin(b + c, 1/2), b = only_a, c = only_b: exact p-value of "no difference".

    `better` "a" or "b": P(X >= b) or P(X >= c), against "A (or B) is no better". `mid` counts half of P(X = observed):
    closer to the level on average, which it may exceed. Broadcasts; 1 where no pair tells the designs apart (one-sided
    mid-p: 1/2). Source: McNemar (1947); Fagerland, Lydersen & Laake (2013).
    """
    b, c = np.broadcast_arrays(whole("only_a", only_a), whole("only_b", only_b))
    fewest = {"either": np.minimum(b, c), "a": c, "b": b}
    if better not in fewest:
        raise invalid('better must be "either", "a" or "b"', repr(better))
    k, n = fewest[better], b + c
    p = binomial_cdf(k, n, 0.5)
    if mid:
        p = (p + binomial_cdf(k - 1, n, 0.5)) / 2
    return np.minimum(1, 2 * p) if better == "either" else p


def log_e_paired(only_a: ArrayLike, only_b: ArrayLike) -> NDArray[np.float64]:
    """ln(B(b + 1, c + 1) 2^(b + c)), b = only_a, c = only_b: the e-process of "no difference", two-sided.

    The likelihood ratio of a share b / (b + c) drawn uniformly from [0, 1] against 1/2. It ever reaches ln(1/alpha) with
    probability <= alpha if the designs are equally good, however often the samples are looked at. Broadcasts. Source:
    Robbins (1970).
    """
    b, c = np.broadcast_arrays(whole("only_a", only_a), whole("only_b", only_b))
    return np.asarray(scipy.special.betaln(b + 1.0, c + 1.0) + (b + c) * math.log(2))


def newcombe(pairs: Pairs, confidence: float = 0.95) -> Estimate:
    """d -+ sqrt(u^2 - 2 phi u v + v^2), u and v the distances from each share to an end of its Wilson interval.

    d = (only_a - only_b) / n; phi is the correlation of the two outcomes; a positive numerator of it is reduced by n / 2.
    Approximate, two-sided. Without pairs the value is NaN and the interval [-1, 1]. Source: Newcombe (1998), method 10.
    """
    e, f, g, h = _checked(pairs)
    n, method = pairs.n, "Newcombe (paired, method 10), approximate"
    check_share("confidence", confidence)
    if not n:
        return Estimate(math.nan, -1.0, 1.0, 0, confidence, method)
    shares = np.array([e + f, e + g]) / n
    ends = wilson(np.array([e + f, e + g]), n, confidence)
    (below_a, below_b), (above_a, above_b) = (shares - ends.low).tolist(), (ends.high - shares).tolist()
    margins = math.sqrt(float(e + f) * float(g + h)) * math.sqrt(float(e + g) * float(f + h))
    excess = e * h - f * g
    phi = (max(excess - n / 2, 0) if excess > 0 else excess) / margins if margins else 0.0
    d = (f - g) / n
    low = d - math.sqrt(below_a**2 - 2 * phi * below_a * above_b + above_b**2)
    high = d + math.sqrt(above_a**2 - 2 * phi * above_a * below_b + below_b**2)
    return Estimate(d, max(low, -1.0), min(high, 1.0), n, confidence, method)


def tango(pairs: Pairs, confidence: float = 0.95) -> Estimate:
    """The differences t with |z(t)| <= the normal quantile of (1 + confidence) / 2, z the score statistic below.

    z(t) = (only_a - only_b - n t) / sqrt(n (2 q + t (1 - t))), q the most likely P(only B) if the difference is t.
    Approximate, two-sided. Without pairs the value is NaN and the interval [-1, 1]. Source: Tango (1998).
    """
    _, f, g, _ = _checked(pairs)
    n, method = pairs.n, "Tango (paired score), approximate"
    check_share("confidence", confidence)
    if not n:
        return Estimate(math.nan, -1.0, 1.0, 0, confidence, method)
    z, d = float(scipy.special.ndtri((1 + confidence) / 2)), (f - g) / n

    def end(inside: float, outside: float) -> float:
        """The point between d and the end of the scale at which |z| reaches its limit."""
        if abs(_score(f, g, n, outside)) <= z:
            return outside
        for _ in range(HALVINGS):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if abs(_score(f, g, n, middle)) <= z else (inside, middle)
        return outside

    return Estimate(d, end(d, -1.0), end(d, 1.0), n, confidence, method)


def noninferiority(pairs: Pairs, margin: float) -> float:
    """P(Z >= z(-margin)), Z normal, z the score statistic of `tango`: p-value of "A is worse than B by margin or more".

    One-sided and approximate. A small value says P(A succeeds) > P(B succeeds) - margin. 1 without pairs. ValueError unless
    0 < margin < 1. Source: Tango (1998).
    """
    check_share("margin", margin)
    _, f, g, _ = _checked(pairs)
    return float(scipy.special.ndtr(-_score(f, g, pairs.n, -margin))) if pairs.n else 1.0


def _score(f: int, g: int, n: int, t: float) -> float:
    """z(t) of `tango`, signed; 0 / 0, at the observed difference, is 0."""
    linear = -f - g + (2 * n - f + g) * t
    q = (math.sqrt(max(0.0, linear**2 + 8 * n * g * t * (1 - t))) - linear) / (4 * n)
    above, variance = f - g - n * t, n * (2 * q + t * (1 - t))
    if variance <= 0:
        return math.copysign(math.inf, above) if above else 0.0
    return above / math.sqrt(variance)


def _checked(pairs: Pairs) -> Pairs:
    if len(pairs) != 4 or any(cell < 0 or cell != int(cell) for cell in pairs):
        raise invalid("pairs must be four whole numbers >= 0", pairs)
    return pairs
