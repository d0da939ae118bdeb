"""Bounds on a share: reference values, and their exact error rates summed over the binomial lattice."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats as oracle

from rvjax.stats import clopper_pearson, clopper_pearson_lower, clopper_pearson_upper, wilks_smallest_n

SMALLEST_N = {  # statistics.md: allowed failures 0, 1, 2, 3, 4, 5, 10
    (0.95, 0.95): (59, 93, 124, 153, 181, 208, 336),
    (0.99, 0.95): (299, 473, 628, 773, 913, 1049, 1693),
    (0.99, 0.90): (230, 388, 531, 667, 798, 926, 1538),
    (0.9973, 0.90): (852, 1440, 1970, 2473, 2959, 3433, 5704),
    (0.99865, 0.90): (1705, 2880, 3941, 4947, 5920, 6868, 11410),
    (0.999, 0.95): (2995, 4742, 6294, 7752, 9151, 10511, 16959),
}


def worst_coverage(lower: NDArray[np.float64], at_least: float = 0.0) -> float:
    """inf over p >= at_least of P(lower[X] <= p), X ~ Bin(n, p), for bounds that rise with the successes 0..n.

    For lower[k] <= p < lower[k + 1] the bound holds iff X <= k, whose probability falls with p: the infimum is the
    smallest limit at a right end.
    """
    n = lower.size - 1
    assert np.all(np.diff(lower) > 0)
    return float(np.min(oracle.binom.cdf(np.arange(n), n, lower[1:])[lower[1:] >= at_least]))


def wilson_lower(k: NDArray[np.int_], n: int, confidence: float) -> NDArray[np.float64]:
    """The score interval's lower end, one-sided: the mutant to kill."""
    z = oracle.norm.ppf(confidence)
    centre = (k + z**2 / 2) / (n + z**2)
    return np.maximum(0, centre - z * np.sqrt(k * (n - k) / n + z**2 / 4) / (n + z**2))


@pytest.mark.parametrize(("share", "confidence"), SMALLEST_N)
def test_smallest_n_reproduces_the_published_table(share: float, confidence: float) -> None:
    """Kills: failures off by one, < for <=, two-sided confidence."""
    found = tuple(wilks_smallest_n(share, confidence, failures) for failures in (0, 1, 2, 3, 4, 5, 10))
    assert found == SMALLEST_N[share, confidence]


@pytest.mark.parametrize(
    ("n", "confidence", "bound"), [(59, 0.95, "0.950492390112"), (299, 0.95, "0.990030853"), (22, 0.90, "0.900628")]
)
def test_bound_without_a_failure_is_the_root_of_the_risk(n: int, confidence: float, bound: str) -> None:
    """p^n = 1 - confidence. Kills: two-sided alpha, n + 1 for n."""
    found = clopper_pearson_lower(n, n, confidence)
    assert f"{found:.{len(bound) - 2}f}" == bound
    assert found == pytest.approx((1 - confidence) ** (1 / n), rel=1e-13)


def test_two_sided_interval_reproduces_the_published_one() -> None:
    """7 of 50 at 95 %. Kills: one-sided alpha in the two-sided interval (.0670, .2476)."""
    found = clopper_pearson(7, 50, 0.95)
    assert (f"{found.low:.7f}", f"{found.high:.7f}") == ("0.0581917", "0.2673960")
    assert (found.value, found.n, found.confidence) == (0.14, 50, 0.95)


@pytest.mark.parametrize(("k", "n"), [(1, 1), (1, 30), (7, 50), (49, 50), (150, 300), (297, 300)])
def test_lower_bound_solves_its_equation_in_exact_arithmetic(k: int, n: int) -> None:
    """P(Bin(n, bound) >= k) = 5 %, summed in fractions. Kills: k + 1 for k, a normal approximation."""
    p = Fraction(clopper_pearson_lower(k, n, 0.95))
    tail = sum(math.comb(n, j) * p**j * (1 - p) ** (n - j) for j in range(k, n + 1))
    assert float(tail) == pytest.approx(0.05, rel=1e-11)


def test_worst_coverage_of_one_sided_95_percent_bounds_at_300() -> None:
    """.9500 for Clopper-Pearson; for Wilson .9324 over p >= 1/2, .7999 over all. Kills: Wilson's in its place."""
    k = np.arange(301)
    exact, wilson = clopper_pearson_lower(k, 300, 0.95), wilson_lower(k, 300, 0.95)
    assert [f"{worst_coverage(exact, half):.4f}" for half in (0, 0.5)] == ["0.9500", "0.9500"]
    assert [f"{worst_coverage(wilson, half):.4f}" for half in (0, 0.5)] == ["0.7999", "0.9324"]


@pytest.mark.parametrize("confidence", [0.5, 0.9, 0.95, 0.999])
@pytest.mark.parametrize("n", [1, 2, 7, 59, 300])
def test_coverage_is_nominal_for_every_share(n: int, confidence: float) -> None:
    """Over every p, lower and upper bound. Kills: any bound that is not conservative somewhere."""
    k = np.arange(n + 1)
    assert worst_coverage(clopper_pearson_lower(k, n, confidence)) >= confidence - 1e-12
    assert worst_coverage((1 - clopper_pearson_upper(k, n, confidence))[::-1]) >= confidence - 1e-12


def test_two_sided_coverage_is_nominal_at_every_end_of_an_interval() -> None:
    """The coverage of [low, high] is smallest just beside an end. Kills: one-sided alpha at each end."""
    n, k = 50, np.arange(51)
    intervals = [clopper_pearson(int(successes), n, 0.95) for successes in k]
    low, high = np.array([i.low for i in intervals]), np.array([i.high for i in intervals])
    ends = np.concatenate([low, high])
    for p in np.clip(np.concatenate([ends - 1e-9, ends + 1e-9]), 0, 1):
        assert oracle.binom.pmf(k, n, p)[(low <= p) & (p <= high)].sum() >= 0.95 - 1e-9


@pytest.mark.parametrize("failures", [0, 1, 4])
@pytest.mark.parametrize(("share", "confidence"), [(0.5, 0.9), (0.9, 0.95), (0.99, 0.95), (0.9973, 0.9)])
def test_smallest_n_is_where_the_lower_bound_reaches_the_share(share: float, confidence: float, failures: int) -> None:
    """Kills: a plan that disagrees with the verdict by one sample."""
    n = wilks_smallest_n(share, confidence, failures)
    assert clopper_pearson_lower(n - failures, n, confidence) >= share
    assert clopper_pearson_lower(n - 1 - failures, n - 1, confidence) < share


def test_ends_and_no_samples() -> None:
    """0 successes: low 0; all: high 1; none flown: everything is possible. Kills: NaN at an end."""
    assert clopper_pearson_lower(0, 10, 0.95) == 0
    assert clopper_pearson_upper(10, 10, 0.95) == 1
    nothing = clopper_pearson(0, 0)
    assert math.isnan(nothing.value)
    assert (nothing.low, nothing.high) == (0, 1)


@pytest.mark.parametrize(("k", "n", "confidence"), [(3, 2, 0.95), (-1, 2, 0.95), (1, 2, 95), (1, 2, 1.0), (1, 2, 0.0)])
def test_impossible_counts_and_confidences_are_refused(k: int, n: int, confidence: float) -> None:
    """Kills: percentages taken for shares."""
    with pytest.raises(ValueError, match="must be between"):
        clopper_pearson_lower(k, n, confidence)
