"""The proved lower bound and Student's interval of replicates: exactly for laws with few values, and as inverses."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from scipy import stats

from rvjax.stats.rare.replicates import BETS, log_e_value, lopsided, proved_lower_bound, student_interval, variation

LAWS = [((0.0, 10.0), (0.9, 0.1)), ((0.5, 3.0), (0.8, 0.2)), ((0.0, 1.0, 4.0), (0.5, 0.3, 0.2))]
"""Values of a replicate and their probabilities."""


@pytest.mark.parametrize(("values", "odds"), LAWS)
def test_the_bound_exceeds_the_mean_as_seldom_as_promised(values: tuple[float, ...], odds: tuple[float, ...]) -> None:
    """Every number of each value among 6 replicates: P(L > mean) ≤ 1 − confidence exactly, at several confidences; and L is
    above the mean somewhere. Kills: a bound that bets more than all, a threshold of another risk."""
    mean, size, bounds = float(np.dot(values, odds)), 6, []
    for counts in product(range(size + 1), repeat=len(values)):
        if sum(counts) == size:
            p = np.repeat(values, counts)
            chance = float(stats.multinomial(size, odds).pmf(counts))
            bounds.append((chance, [proved_lower_bound(p, confidence) for confidence in (0.5, 0.8, 0.95)]))
    for place, confidence in enumerate((0.5, 0.8, 0.95)):
        assert sum(chance for chance, low in bounds if low[place] > mean * (1 + 1e-12)) <= 1 - confidence
    assert max(low[0] for _, low in bounds) > mean


def test_the_evidence_is_the_mixture_of_products() -> None:
    """By its definition, with numbers of Python. Kills: a missing weight, a sum for the product."""
    p, m = [2e-7, 1.5e-6, 0.0, 9e-7], 8e-7
    products = [math.prod(1 + bet * (x / m - 1) for x in p) for bet in BETS]
    assert math.exp(log_e_value(p, m)) == pytest.approx(sum(products) / len(BETS), rel=1e-12)


def test_the_bound_is_where_the_evidence_reaches_its_limit() -> None:
    """E(L) = 1/α, and more below. Kills: a bisection that ends at the wrong side, α of two sides."""
    p = np.random.default_rng(1).lognormal(-14.0, 0.3, 20)
    for confidence in (0.9, 0.975):
        low = proved_lower_bound(p, confidence)
        assert math.exp(log_e_value(p, low)) == pytest.approx(1 / (1 - confidence), rel=1e-9)
        assert log_e_value(p, 0.9 * low) > log_e_value(p, low)
    assert proved_lower_bound([0.0] * 30, 0.95) == 0.0
    assert proved_lower_bound([1e-6], 0.95) == pytest.approx(1e-6 * 0.05, rel=0.75)


def test_student_is_that_of_scipy() -> None:
    """Kills: n for n − 1, one side for two, a bound below 0."""
    p = np.random.default_rng(2).lognormal(-14.0, 0.5, 20)
    interval = stats.t.interval(0.9, 19, p.mean(), stats.sem(p))
    came = student_interval(p, 0.9)
    assert (came.value, came.low, came.high) == pytest.approx((p.mean(), *interval), rel=1e-12)
    assert "nominal" in came.method
    assert student_interval([0.0, 0.0, 1e-6], 0.95).low == 0.0
    assert (student_interval([1e-6], 0.95).low, student_interval([1e-6], 0.95).high) == (0.0, 1.0)
    assert variation(p) == pytest.approx(p.std(ddof=1) / p.mean(), rel=1e-12)
    with pytest.raises(ValueError, match="not negative"):
        proved_lower_bound([-1e-9], 0.95)


def test_lopsided_replicates_are_named() -> None:
    """Nine replicates above 0, one that is 60 % of the sum, and ten equal ones. Kills: a missing rule, a limit off by one."""
    assert lopsided([0.0] * 11 + [1e-6] * 9) == "only 9 of 20 replicates reached a failure"
    assert lopsided([1e-6] * 10 + [15e-6]) == "one of 11 replicates is 60 % of their sum"
    assert lopsided([1e-6] * 10) == ""
