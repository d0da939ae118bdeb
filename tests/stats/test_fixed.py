"""Verdicts with a fixed number of samples: their exact errors; intervals for plots and how far they fall short."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats as oracle

from rvjax.stats import (
    clopper_pearson_lower,
    clopper_pearson_upper,
    coverage,
    fixed_boundary,
    jeffreys,
    verdict_chances,
    wilks_smallest_n,
    wilson,
    worst_coverage,
)

PLANS = [(0.5, 0.8), (0.5, 0.95), (0.8, 0.9), (0.9, 0.95), (0.95, 0.95), (0.95, 0.99)]
PLANS += [(0.99, 0.9), (0.99, 0.95), (0.99, 0.999), (0.9973, 0.9), (0.99865, 0.9), (0.999, 0.95)]
SIZES = np.array([0, 1, 2, 5, 22, 58, 59, 60, 93, 298, 299, 473, 1000, 3000])


@pytest.mark.parametrize(("p0", "confidence"), PLANS)
def test_boundary_is_that_of_the_clopper_pearson_bounds(p0: float, confidence: float) -> None:
    """Every count of every size, in any order of sizes. Kills: <= for the < of FAIL, a count off by one, sizes left sorted."""
    found = fixed_boundary(SIZES[::-1], p0, confidence)
    for n, most, least in zip(*found, strict=True):
        failures = np.arange(n + 1)
        assert np.array_equal(failures <= most, clopper_pearson_lower(n - failures, n, confidence) >= p0)
        assert np.array_equal(failures >= least, clopper_pearson_upper(n - failures, n, confidence) < p0)


@pytest.mark.parametrize(("p0", "confidence"), PLANS)
def test_each_error_of_a_verdict_is_below_nominal(p0: float, confidence: float) -> None:
    """P(PASS) for p <= p0 and P(FAIL) for p >= p0, summed; both are largest at p0. Kills: two-sided risk, PASS from n - 1 on."""
    risk = 1 - confidence
    for n in SIZES.tolist():
        failures = np.arange(n + 1)
        passing = clopper_pearson_lower(n - failures, n, confidence) >= p0
        failing = clopper_pearson_upper(n - failures, n, confidence) < p0
        for p in (p0 - 0.3 * (1 - p0), p0, p0 + 0.3 * (1 - p0), 1.0):
            law = oracle.binom.pmf(failures, n, 1 - p)
            passes, fails, undecided = verdict_chances(n, p0, confidence, p)
            assert passes == pytest.approx(law[passing].sum(), abs=1e-12)
            assert fails == pytest.approx(law[failing].sum(), abs=1e-12)
            assert passes + fails + undecided == pytest.approx(1, abs=1e-12)
            assert p > p0 or passes <= risk + 1e-12
            assert p < p0 or fails <= risk + 1e-12


@pytest.mark.parametrize(("failures", "share"), [(0, "47"), (2, "79"), (5, "95")])
def test_power_at_a_quarter_of_the_limits_failure_rate(failures: int, share: str) -> None:
    """.99/.95 and p = .9975: plans without a failure to spare rarely pass. Kills: the consumer's risk in place of the power."""
    n = wilks_smallest_n(0.99, 0.95, failures)
    assert f"{100 * float(verdict_chances(n, 0.99, 0.95, 0.9975).passes):.0f}" == share


def test_chances_have_the_shape_of_sizes_and_shares() -> None:
    """Kills: a loop over one of the two only."""
    found = verdict_chances(SIZES[:, None], 0.9, 0.95, np.linspace(0, 1, 5))
    assert {part.shape for part in found} == {(SIZES.size, 5)}
    assert found.passes[-1, -1] == 1
    assert found.fails[-1, 0] == 1


@pytest.mark.parametrize(("p0", "confidence", "p"), [(0.0, 0.9, 0.5), (0.5, 90, 0.5), (0.5, 0.9, 1.1), (0.5, 0.9, math.nan)])
def test_what_is_no_share_is_refused(p0: float, confidence: float, p: float) -> None:
    """Kills: a check that is left out."""
    with pytest.raises(ValueError, match="must be between"):
        verdict_chances(10, p0, confidence, p)


def test_sizes_that_are_no_whole_numbers_are_refused() -> None:
    """Kills: rounding down what was meant otherwise."""
    for sizes in ([1.5], [-1], [math.nan]):
        with pytest.raises(ValueError, match="looks must be whole numbers >= 0"):
            fixed_boundary(sizes, 0.9, 0.95)


def test_worst_coverage_of_one_sided_lower_bounds_at_300() -> None:
    """.9500 Clopper-Pearson; above one half Wilson .9324, Jeffreys .8533. Kills: one of the two in its place, a shifted end."""
    k, one = np.arange(301), np.ones(301)
    low = (clopper_pearson_lower(k, 300, 0.95), wilson(k, 300, 0.9).low, jeffreys(k, 300, 0.9).low)
    assert [f"{worst_coverage(ends, one, least=0.5):.4f}" for ends in low] == ["0.9500", "0.9324", "0.8533"]


@pytest.mark.parametrize("interval", [wilson, jeffreys])
def test_worst_coverage_is_the_least_there_is(interval: object) -> None:
    """Against a fine grid, and attained just beside an end. Kills: one-sided limits left out, the coverage at the ends only."""
    n, k = 25, np.arange(26)
    low, high = interval(k, n, 0.9)  # type: ignore[operator]
    grid = np.unique(np.concatenate([np.linspace(0, 1, 2001), *(np.clip(np.r_[low, high] + d, 0, 1) for d in (-1e-10, 1e-10))]))
    by_hand = [oracle.binom.pmf(k, n, p)[(low <= p) & (p <= high)].sum() for p in grid]
    assert coverage(low, high, grid) == pytest.approx(by_hand, abs=1e-12)
    assert worst_coverage(low, high) == pytest.approx(min(by_hand), abs=1e-7)
    within = [one for p, one in zip(grid, by_hand, strict=True) if 0.2 <= p <= 0.4]
    assert worst_coverage(low, high, 0.2, 0.4) == pytest.approx(min(within), abs=1e-7)


@pytest.mark.parametrize("n", [1, 10, 300])
def test_intervals_for_plots_agree_with_their_definitions(n: int) -> None:
    """Wilson's against SciPy's, Jeffreys' against the Beta law. Kills: a missing z^2, Beta(1, 1), ends that miss 0 and 1."""
    for k in range(n + 1):
        reference = oracle.binomtest(k, n).proportion_ci(0.9, "wilson")
        assert np.ravel(wilson(k, n, 0.9)) == pytest.approx([reference.low, reference.high], abs=1e-12)
        law = oracle.beta(k + 0.5, n - k + 0.5)
        expected = [law.ppf(0.05) if k else 0, law.ppf(0.95) if k < n else 1]
        assert np.ravel(jeffreys(k, n, 0.9)) == pytest.approx(expected, abs=1e-12)


def test_intervals_that_fall_are_refused() -> None:
    """Kills: a coverage that is wrong in silence."""
    with pytest.raises(ValueError, match="neither falling"):
        coverage([0.5, 0.1], [1, 1], 0.5)


@pytest.mark.parametrize("p0", [0.5, 0.9, 0.999])
def test_edges_of_many_sizes_at_once_are_those_one_by_one(p0: float) -> None:
    """Sizes with gaps, repeated, in two dimensions. Kills: a coarse pass that skips a size, an end that is taken as known."""
    sizes = np.concatenate([np.arange(700), [5000, 5000, 70_000], np.arange(3000, 3097)]).reshape(-1, 2, 2)
    together = fixed_boundary(sizes, p0, 0.95)
    assert together.passes.shape == sizes.shape
    for n, most in list(zip(sizes.ravel().tolist(), together.passes.ravel().tolist(), strict=True))[::7]:
        enough = oracle.binom.cdf(np.array([most, most + 1]), n, 1 - p0) <= 0.05
        assert enough.tolist() == [True, False]
    assert all(one <= other for one, other in pairwise(together.passes.ravel()[:700]))
