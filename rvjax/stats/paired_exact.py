"""The exact unconditional test of a margin between two designs flown on the same draws.

The statistic is Tango's score z at the difference -margin. It rises with the pairs f that succeed under A only and falls with the
pairs g that succeed under B only. With P(only A) = q and P(only B) = q + margin, A is worse than B by just the margin, and

    p = sup over q of P(z >= the observed z),    P = Σ_f Bin(f; n, q) P(X <= g(f)),  X ~ Bin(n - f, (q + margin) / (1 - q))

g(f) is the largest g whose z is as large. Where A is worse by more, the probability is smaller (Barnard's convexity). The
supremum is searched on a grid of q that is refined around its largest values.

Sources: G. A. Barnard, Biometrika 34 (1947) 123; T. Tango, Stat. Med. 17 (1998) 891; J. Liu, K. K. Tsou & H. M. Wang, Stat. Med.
24 (2005) 1565 (exact tests of non-inferiority in pairs).
"""

from __future__ import annotations

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import NDArray

from rvjax.stats._binomial import binomial_cdf, check_share
from rvjax.stats.paired import Pairs

GRID = 120
"""Values of q, denser near 0, where P changes fastest."""

PEAKS = 3
REFINEMENTS = 6
"""The grid is refined around its `PEAKS` largest values, `REFINEMENTS` times."""

REACH = 9.0
"""Standard deviations of a binomial that are summed; beyond lies less than 1e-17."""

TIES = 1e-9
"""Scores that differ by less, relatively, count as equal: rounding."""

Values = NDArray[np.float64]


def noninferiority_exact(pairs: Pairs, margin: float) -> float:
    """Exact p-value of "A is worse than B by margin or more": a small value says P(A succeeds) > P(B succeeds) - margin.

    1 without pairs. ValueError unless 0 < margin < 1.
    """
    return _p_value(pairs, margin, worse=False)


def inferiority_exact(pairs: Pairs, margin: float) -> float:
    """Exact p-value of "A is worse than B by less than margin": a small value says P(A succeeds) < P(B succeeds) - margin.

    The same statistic, extreme where it is small: P(z <= the observed z). 1 without pairs. ValueError unless 0 < margin < 1.
    """
    return _p_value(pairs, margin, worse=True)


def _p_value(pairs: Pairs, margin: float, worse: bool) -> float:
    check_share("margin", margin)
    n = pairs.n
    if not n:
        return 1.0
    most = _largest(n, margin, float(_scores(np.array(pairs.only_a), np.array(pairs.only_b), n, margin)), strict=worse)

    def probability(q: float) -> float:
        middle, reach = n * q, REACH * np.sqrt(n * q * (1.0 - q)) + REACH**2
        f = np.arange(max(0, int(middle - reach)), min(n, int(middle + reach)) + 1)
        weight = np.exp(
            scipy.special.gammaln(n + 1) - scipy.special.gammaln(f + 1) - scipy.special.gammaln(n - f + 1) + _powers(f, n - f, q)
        )
        inside = binomial_cdf(most[f], n - f, min((q + margin) / (1.0 - q), 1.0))
        return float(np.sum(weight * ((1.0 - inside) if worse else inside)))

    ends = (1.0 - margin) / 2.0
    grid = ends * np.linspace(0.0, 1.0, GRID + 1) ** 2
    values = np.array([probability(q) for q in grid])
    best = float(values.max())
    for place in np.argsort(values)[-PEAKS:]:
        low, high = grid[max(place - 1, 0)], grid[min(place + 1, GRID)]
        for _ in range(REFINEMENTS):
            points = np.linspace(low, high, 5)
            found = [probability(q) for q in points]
            top = int(np.argmax(found))
            best = max(best, found[top])
            low, high = points[max(top - 1, 0)], points[min(top + 1, 4)]
    return min(best, 1.0)


def _largest(n: int, margin: float, seen: float, strict: bool) -> NDArray[np.int64]:
    """(n + 1,) for each f the largest g <= n - f with z >= seen, or z > seen if `strict`; -1 if there is none."""
    f = np.arange(n + 1)
    inside, outside = np.full(n + 1, -1), n - f + 1
    tolerance = TIES * (1.0 + abs(seen)) if np.isfinite(seen) else 0.0
    while (outside - inside > 1).any():
        middle = (inside + outside) // 2
        z = _scores(f, np.maximum(middle, 0), n, margin)
        reached = (z > seen + tolerance if strict else z >= seen - tolerance) & (middle >= 0)
        inside, outside = np.where(reached, middle, inside), np.where(reached, outside, middle)
    return inside


def _scores(f: NDArray[np.int64], g: NDArray[np.int64], n: int, margin: float) -> Values:
    """z(-margin) of Tango, elementwise: (f - g + n margin) over its standard deviation."""
    linear = -f - g - (2 * n - f + g) * margin
    root = np.sqrt(np.maximum(0.0, linear**2 - 8.0 * n * g * margin * (1.0 + margin)))
    variance = n * (2.0 * (root - linear) / (4.0 * n) - margin * (1.0 + margin))
    above = f - g + n * margin
    with np.errstate(divide="ignore", invalid="ignore"):
        z = above / np.sqrt(np.maximum(variance, 0.0))  # ±∞ without variance, NaN for 0 / 0
    return np.where(np.isnan(z), 0.0, z)


def _powers(k: NDArray[np.int64], rest: NDArray[np.int64], q: float) -> Values:
    """ln(q^k (1 - q)^rest), with 0^0 = 1."""
    return scipy.special.xlogy(k, q) + scipy.special.xlog1py(rest, -q)
