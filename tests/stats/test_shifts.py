"""Shifts of quantiles: the fast bootstrap is the plain one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rvjax.stats import quantile_shift


def plain(a: np.ndarray, b: np.ndarray, q: float, resamples: int, seed: int) -> np.ndarray:
    """Quantile shifts of pairs drawn anew, by sorting whole resamples."""
    generator = np.random.default_rng(seed)
    rank = math.ceil(q * len(a)) - 1
    found = np.empty(resamples)
    for resample in range(resamples):
        chosen = generator.integers(len(a), size=len(a))
        found[resample] = np.sort(b[chosen])[rank] - np.sort(a[chosen])[rank]
    return found


@pytest.mark.parametrize(("n", "q"), [(60, 0.5), (400, 0.95), (3000, 0.9)])
def test_the_interval_is_that_of_the_plain_bootstrap(n: int, q: float) -> None:
    """Ends within four standard errors of a percentile of 4,000 resamples. Kills: sides resampled apart, pairs far from the
    quantile left out, a rank off by many."""
    generator = np.random.Generator(np.random.Philox(key=n))
    a = generator.normal(size=n)
    b = 0.8 * a + 0.3 + generator.normal(0, 0.3, n)
    found = quantile_shift(a, b, q, 0.9, rng=np.random.default_rng(1), resamples=4000)
    shifts = np.sort(plain(a, b, q, 4000, 2))
    rank = math.ceil(q * n) - 1
    assert found.value == pytest.approx(np.sort(b)[rank] - np.sort(a)[rank])
    near = 4 * math.sqrt(0.05 * 0.95 / 4000) * math.sqrt(2)
    for end, share in ((found.low, 0.05), (found.high, 0.95)):
        low, high = np.quantile(shifts, [max(0.0, share - near), min(1.0, share + near)])
        assert low <= end <= high


def test_what_is_not_finite_is_the_worst() -> None:
    """Kills: NaN that is dropped on one side, which would shift pairs against each other; an infinite shift that is NaN."""
    a = np.arange(100.0)
    b = a + 1.0
    b[::3] = math.nan
    found = quantile_shift(a, b, 0.5, rng=np.random.default_rng(1))
    assert found.value == pytest.approx(np.sort(np.where(np.isnan(b), np.inf, b))[49] - 49.0)
    both = quantile_shift(np.full(50, np.inf), np.full(50, np.inf), 0.5, rng=np.random.default_rng(1))
    assert math.isnan(both.value)
    assert (both.low, both.high) == (-math.inf, math.inf)
    assert quantile_shift([], [], 0.5, rng=np.random.default_rng(1)).n == 0
    with pytest.raises(ValueError, match="pairs"):
        quantile_shift([1.0], [1.0, 2.0], 0.5, rng=np.random.default_rng(1))


def test_a_million_pairs_take_little() -> None:
    """All pairs shifted by one: the interval is a point. Kills: a bootstrap that grows with pairs times resamples."""
    a = np.random.Generator(np.random.Philox(key=3)).normal(size=10**6)
    found = quantile_shift(a, a + 1.0, 0.95, rng=np.random.default_rng(1), resamples=200)
    assert (found.low, found.value, found.high) == pytest.approx((1.0, 1.0, 1.0))
