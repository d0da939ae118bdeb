"""The exact test of a margin, against sums over every table and a score by numerical maximum likelihood."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import optimize, stats

from rvjax.stats import Pairs, inferiority_exact, noninferiority, noninferiority_exact

Q = np.linspace(0.0, 1.0, 301) ** 1.5


def tables(n: int) -> list[tuple[int, int]]:
    """Every (only A, only B) of n pairs."""
    return [(f, g) for f in range(n + 1) for g in range(n + 1 - f)]


def laws(n: int, margin: float, found: list[tuple[int, int]]) -> NDArray[np.float64]:
    """(tables, 301) probability of each table where A is worse by just the margin, over the nuisance share P(only A)."""
    q = Q * (1.0 - margin) / 2.0
    cells = np.array([[f, g, n - f - g] for f, g in found])
    p = np.maximum([q, q + margin, 1.0 - 2.0 * q - margin], 0.0).T
    return np.array([stats.multinomial.pmf(cells, n, row / row.sum()) for row in p]).T


def score(f: int, g: int, n: int, margin: float) -> float:
    """(f − g + n margin) / its standard deviation under the most likely P(only A) = q, by search."""

    def unlikely(q: float) -> float:
        chances = ((f, q), (g, q + margin), (n - f - g, 1.0 - 2.0 * q - margin))
        return -sum(k * math.log(max(p, 1e-300)) for k, p in chances if k)

    end = (1.0 - margin) / 2.0
    q = float(optimize.minimize_scalar(unlikely, bounds=(0.0, end), method="bounded", options={"xatol": 1e-13}).x)
    q = min((0.0, q, end), key=unlikely)
    variance = n * (2.0 * q + margin - margin**2)
    return (f - g + n * margin) / math.sqrt(variance)


@pytest.mark.parametrize(("n", "margin"), [(1, 0.05), (6, 0.3), (12, 0.1), (12, 0.02)])
def test_p_is_the_supremum_over_the_nuisance_share(n: int, margin: float, full: bool) -> None:
    """Every table, of 8 pairs at most without `--long`, by brute force. Kills: an average for the supremum, a margin of the other
    sign, A for B, an outcome as extreme as the observed that is left out, the supremum at the ends of the shares only."""
    n = n if full else min(n, 8)
    found = tables(n)
    chances = laws(n, margin, found)
    z = np.array([score(f, g, n, margin) for f, g in found])
    for index, (f, g) in enumerate(found):
        pairs = Pairs(n - f - g, f, g, 0)
        for p, extreme in (
            (noninferiority_exact(pairs, margin), z >= z[index] - 1e-6),
            (inferiority_exact(pairs, margin), z <= z[index] + 1e-6),
        ):
            most = chances[extreme].sum(axis=0).max()
            assert most - 1e-9 <= p <= most + 2e-3, (f, g, p, most)


@pytest.mark.parametrize(("n", "margin"), [(20, 0.05), (12, 0.2)])
def test_it_errs_at_most_as_often_as_promised(n: int, margin: float, full: bool) -> None:
    """The chance of a small p-value where A is worse by just the margin, summed over all tables, at the worst nuisance share; of
    20 pairs by one test without `--long`. Kills: the score test in its place, which errs in 5.8 % at 20 pairs and a margin of
    0.05 where 5 % are promised."""
    found = tables(n)
    chances = laws(n, margin, found)
    pairs = [Pairs(n - f - g, f, g, 0) for f, g in found]
    for test in (noninferiority_exact, inferiority_exact) if full or n < 20 else (noninferiority_exact,):
        p = np.array([test(pair, margin) for pair in pairs])
        for risk in (0.01, 0.05, 0.1):
            assert chances[p <= risk].sum(axis=0).max() <= risk + 1e-9
    if (n, margin) == (20, 0.05):
        approximate = np.array([noninferiority(pair, margin) for pair in pairs])
        assert 0.055 < chances[approximate <= 0.05].sum(axis=0).max() < 0.06


@pytest.mark.parametrize(("n", "margin"), [(59, 0.05), (299, 0.01)])
def test_pairs_without_a_difference_need_as_many_samples_as_all_successes(n: int, margin: float) -> None:
    """p = (1 − Δ)ⁿ where no pair tells the designs apart. Kills: a supremum at another share, a tail that is cut too early."""
    assert noninferiority_exact(Pairs(n, 0, 0, 0), margin) == pytest.approx((1.0 - margin) ** n, rel=1e-9)
    assert inferiority_exact(Pairs(n, 0, 0, 0), margin) == pytest.approx(1.0)


def test_many_pairs_agree_with_the_score_test() -> None:
    """At 100,000 pairs the score test is as good as exact. Kills: a window of the binomial that misses its mass."""
    for f, g in ((200, 1100), (200, 1300)):
        pairs = Pairs(100_000 - f - g, f, g, 0)
        p, q = noninferiority_exact(pairs, 0.01), inferiority_exact(pairs, 0.01)
        assert p == pytest.approx(noninferiority(pairs, 0.01), rel=0.15)
        assert q == pytest.approx(1.0 - noninferiority(pairs, 0.01), rel=0.15)


def test_without_pairs_or_with_an_impossible_margin() -> None:
    assert noninferiority_exact(Pairs(0, 0, 0, 0), 0.1) == inferiority_exact(Pairs(0, 0, 0, 0), 0.1) == 1.0
    for margin in (0.0, 1.0, math.nan):
        with pytest.raises(ValueError, match="margin must be between"):
            noninferiority_exact(Pairs(1, 1, 1, 1), margin)
