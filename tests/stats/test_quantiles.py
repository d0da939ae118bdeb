"""Quantiles, bands and means: exact coverage, summed over the lattice of what the sample can be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats as oracle

from rvjax.stats import (
    dkw_band,
    lower_tolerance_bound,
    mean_interval,
    quantile_interval,
    tolerance_interval,
    upper_tolerance_bound,
    wilks_smallest_n,
)
from rvjax.stats.quantile_sketch import RELATIVE_ERROR, Sketch

PLANS = [(n, q, c) for n in (1, 2, 10, 59, 100, 473) for q in (0.05, 0.5, 0.9, 0.99) for c in (0.8, 0.95)]


@pytest.mark.parametrize(("n", "q", "confidence"), PLANS)
def test_quantile_interval_covers_exactly_as_promised(n: int, q: float, confidence: float) -> None:
    """The values 1..n are their own ranks l, u: for continuous values the true quantile lies below x_(l) iff fewer than
    l of them are <= it, so each side's risk is a binomial tail. Kills: l or u off by one either way, swapped tails.
    """
    found = quantile_interval(np.random.default_rng(0).permutation(n) + 1.0, q, confidence)
    low = 0 if found.low == -math.inf else int(found.low)
    high = n + 1 if found.high == math.inf else int(found.high)
    risk = (1 - confidence) / 2 + 1e-12
    assert oracle.binom.cdf(low - 1, n, q) <= risk
    assert oracle.binom.sf(high - 1, n, q) <= risk
    assert oracle.binom.cdf(low, n, q) > risk - 2e-12, "a higher lower end would do"
    assert high == 1 or oracle.binom.sf(high - 2, n, q) > risk - 2e-12, "a lower upper end would do"
    assert max(low, 1) <= found.value <= min(high, n)


@pytest.mark.parametrize("p", [0.02, 0.3, 0.5, 0.8, 0.97])
@pytest.mark.parametrize("q", [0.1, 0.5, 0.95])
def test_quantile_interval_covers_where_values_tie(p: float, q: float) -> None:
    """Values 0 or +inf only, P(+inf) = p, summed over the number of each. Kills: bounds that need continuity."""
    n, truth = 40, 0.0 if q <= 1 - p else math.inf
    covered = 0.0
    for infinite in range(n + 1):
        found = quantile_interval([0.0] * (n - infinite) + [math.inf] * infinite, q, 0.9)
        assert found.low <= found.value <= found.high
        covered += float(oracle.binom.pmf(infinite, n, p)) * (found.low <= truth <= found.high)
    assert covered >= 0.9 - 1e-12


def test_quantile_is_a_value_that_occurred() -> None:
    """x_(ceil(n q)), no interpolation. Kills: 0-based ranks, interpolation, the rounding of n q (100 x .07 > 7)."""
    values = np.arange(1.0, 101.0)
    assert [quantile_interval(values, q).value for q in (0.005, 0.07, 0.5, 0.951, 0.99)] == [1, 7, 50, 96, 99]


@pytest.mark.parametrize("n", [1, 30, 8192, 8193, 60_000])
def test_interval_from_a_sketch_holds_that_of_the_numbers(n: int) -> None:
    """Equal to it up to 8192 numbers. Kills: a rank off by one, an end moved inwards, the middle of a bucket as its edge."""
    generator = np.random.Generator(np.random.Philox(key=8))
    x = generator.lognormal(0, 4, n) * generator.choice([1.0, 1.0, -1.0], n)
    x[generator.uniform(size=n) < 0.05] = math.inf
    sketch = Sketch(x)
    for q in (0.001, 0.05, 0.3, 0.5, 0.9, 0.95, 0.9999):
        for confidence in (0.5, 0.95):
            found, exact = quantile_interval(sketch, q, confidence), quantile_interval(x, q, confidence)
            assert found.low <= exact.low <= exact.high <= found.high
            assert found.low <= found.value <= found.high
            for one, other in ((found.low, exact.low), (found.high, exact.high)):
                assert one == other or abs(one - other) <= 2 * RELATIVE_ERROR * abs(other) * (1 + 1e-12)
            assert found.value == exact.value or abs(found.value - exact.value) <= RELATIVE_ERROR * abs(exact.value) * (1 + 1e-12)
            assert (found == exact) == (n <= 8192)


def test_nan_is_the_worst_value_whichever_side_that_is() -> None:
    """Kills: dropping NaN, NaN sorted as +inf where higher is better."""
    values = [1.0, 2.0, 3.0, math.nan]
    assert quantile_interval(values, 0.99).value == math.inf
    assert quantile_interval(values, 0.01, worst=-math.inf).value == -math.inf
    assert quantile_interval(values, 0.5).n == 4
    assert upper_tolerance_bound([math.nan, *range(1, 93)], 0.95, 0.95) == 92
    assert lower_tolerance_bound([*range(58), math.nan], 0.95, 0.95) == -math.inf


@pytest.mark.parametrize(("q", "confidence"), [(0.95, 0.95), (0.99, 0.9), (0.9973, 0.9)])
@pytest.mark.parametrize("failures", [0, 1, 5])
def test_tolerance_bound_is_the_order_statistic_of_wilks(q: float, confidence: float, failures: int) -> None:
    """x_(n - k) from n = the planned n on, +inf or the next larger below it. Kills: rank off by one, two-sided risk."""
    n = wilks_smallest_n(q, confidence, failures)
    ranks = np.arange(1.0, n + 1)
    assert upper_tolerance_bound(ranks, q, confidence) == n - failures
    assert upper_tolerance_bound(ranks[:-1], q, confidence) == (n - failures if failures else math.inf)
    assert lower_tolerance_bound(ranks, q, confidence) == 1 + failures


@pytest.mark.parametrize(("q", "n"), [(0.95, 93), (0.99, 473)])
def test_smallest_and_largest_value_enclose_the_share(q: float, n: int) -> None:
    """1 - n q^(n-1) + (n-1) q^n >= .95 first at n. Kills: failures = 0 for the two-sided plan."""
    assert wilks_smallest_n(q, 0.95, failures=1) == n
    enclosed = [1 - m * q ** (m - 1) + (m - 1) * q**m for m in (n - 1, n)]
    assert enclosed[0] < 0.95 <= enclosed[1]


@pytest.mark.parametrize(("q", "n"), [(0.95, 93), (0.99, 473)])
def test_tolerance_interval_is_from_the_smallest_to_the_largest_value_first(q: float, n: int) -> None:
    """At the published n, and infinite below it. Kills: one side's risk for both, n - 1."""
    assert tolerance_interval(np.arange(n)[::-1], q, 0.95) == (0, n - 1)
    assert tolerance_interval(np.arange(n - 1), q, 0.95) == (-math.inf, math.inf)
    assert tolerance_interval([*range(n - 1), math.nan], q, 0.95) == (0, math.inf)


@pytest.mark.parametrize("confidence", [0.5, 0.9, 0.99])
@pytest.mark.parametrize(("n", "q"), [(2, 0.2), (50, 0.8), (51, 0.5), (400, 0.95), (1000, 0.9)])
def test_tolerance_interval_is_the_narrowest_of_equal_ranks(n: int, q: float, confidence: float) -> None:
    """The share between x_(m) and x_(n+1-m) is Beta(n + 1 - 2 m, 2 m). Kills: a rank off by one either way, P(... < 2 m)."""
    found = tolerance_interval(np.arange(1.0, n + 1), q, confidence)
    m = 0 if found.low == -math.inf else int(found.low)
    assert m == 0 or (found.high == n + 1 - m and oracle.beta.sf(q, n + 1 - 2 * m, 2 * m) >= confidence)
    assert 2 * m + 2 > n or oracle.beta.sf(q, n + 1 - 2 * (m + 1), 2 * (m + 1)) < confidence


@pytest.mark.parametrize("confidence", [0.9, 0.95, 0.99])
@pytest.mark.parametrize("n", [5, 50, 1000])
def test_band_holds_everywhere_at_once(n: int, confidence: float) -> None:
    """Against the exact law of sup |F_n - F|. Kills: ln(1 / alpha), a factor 2 that is missing, a pointwise band."""
    half_width = dkw_band(n, confidence)
    assert confidence <= oracle.kstwo.cdf(half_width, n) <= (1 if n < 50 else confidence + 0.3 * (1 - confidence))
    assert n < 50 or oracle.kstwo.cdf(math.sqrt(math.log(1 / (1 - confidence)) / (2 * n)), n) < confidence


def test_band_of_nothing_says_nothing() -> None:
    """Kills: a division by zero, a band wider than all shares."""
    assert dkw_band(0, 0.95) == 1
    assert dkw_band(1, 0.95) == 1


def test_no_values_bound_nothing() -> None:
    """Kills: an index error on an empty table."""
    for found in (quantile_interval([], 0.5), mean_interval([])):
        assert math.isnan(found.value)
    assert (quantile_interval([], 0.5).low, quantile_interval([], 0.5).high) == (-math.inf, math.inf)
    assert upper_tolerance_bound([], 0.5, 0.9) == math.inf


def test_mean_interval_covers_roughly_and_says_so() -> None:
    """Values 0 or 1, so the interval depends on their number only and its coverage is a finite sum.

    Kills: a normal quantile of the wrong side, swapped ends, half the confidence.
    """
    n = 40
    found = [mean_interval([1.0] * ones + [0.0] * (n - ones), 0.9) for ones in range(n + 1)]
    for p in (0.2, 0.5, 0.7):
        held = np.array([one.low <= p <= one.high for one in found])
        assert 0.86 <= oracle.binom.pmf(np.arange(n + 1), n, p)[held].sum() <= 0.96
    assert all(one.low <= one.value <= one.high and "approximate" in one.method for one in found)


def test_mean_interval_leans_to_the_long_tail_and_repeats() -> None:
    """Quantiles of an exponential law. Kills: acceleration or bias of the wrong sign, an unfixed generator."""
    values = oracle.expon.ppf((np.arange(60) + 0.5) / 60)
    found = mean_interval(values)
    reference = oracle.bootstrap((values,), np.mean, method="BCa", rng=np.random.default_rng(1))
    width = found.high - found.low
    assert found.high - found.value > 1.15 * (found.value - found.low)
    assert found.low == pytest.approx(reference.confidence_interval.low, abs=0.1 * width)
    assert found.high == pytest.approx(reference.confidence_interval.high, abs=0.1 * width)
    assert mean_interval(values[::-1]) == found
    mirrored = mean_interval(-values)
    assert mirrored.value - mirrored.low > 1.15 * (mirrored.high - mirrored.value)


def test_mean_of_a_value_that_is_not_finite_is_infinite() -> None:
    """Kills: dropping the samples that never settled from a mean."""
    found = mean_interval([1.0, 2.0, math.nan])
    assert (found.low, found.value, found.high) == (math.inf, math.inf, math.inf)
