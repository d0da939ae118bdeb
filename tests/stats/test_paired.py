"""Two designs on common draws: published examples, definitions solved numerically, exact sizes and coverage."""

from __future__ import annotations

import itertools
import math
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import optimize
from scipy import stats as oracle
from scipy.special import gammaln, xlogy

from rvjax.stats import (
    Boundary,
    Pairs,
    log_e_paired,
    mcnemar,
    newcombe,
    noninferiority,
    pairs_of,
    quantile_shift,
    schedule,
    tango,
    walk,
)

SHARES = (0.5, 0.7, 0.8, 0.9, 0.95)
LAWS = [  # probabilities of the four cells, from two shares and their correlation
    cells
    for a, b, phi in itertools.product(SHARES, SHARES, (0.0, 0.5, 0.9))
    for both in [a * b + phi * math.sqrt(a * (1 - a) * b * (1 - b))]
    for cells in [np.array([both, a - both, b - both, 1 - a - b + both])]
    if cells.min() >= 0
]


@cache
def tables(n: int) -> NDArray[np.int64]:
    """All numbers of pairs that n draws can fall into, (tables, 4)."""
    return np.array([(e, f, g, n - e - f - g) for e in range(n + 1) for f in range(n + 1 - e) for g in range(n + 1 - e - f)])


def likelihood(n: int, cells: NDArray[np.float64]) -> NDArray[np.float64]:
    """The multinomial probability of each of the tables."""
    return np.exp(gammaln(n + 1) - gammaln(tables(n) + 1).sum(axis=1) + xlogy(tables(n), np.maximum(cells, 0)).sum(axis=1))


@pytest.mark.parametrize(
    ("only_a", "only_b", "exact", "mid"),
    [(1, 7, ".0703", ".0391"), (12, 2, ".0129", None), (3, 12, ".0352", ".0213"), (6, 16, ".0525", ".0347")],
)
def test_mcnemar_reproduces_published_p_values(only_a: int, only_b: int, exact: str, mid: str | None) -> None:
    """Kills: one-sided for two-sided, the whole of P(X = observed) in mid-p."""
    assert f"{float(mcnemar(only_a, only_b)):.4f}"[1:] == exact
    assert mid is None or f"{float(mcnemar(only_a, only_b, mid=True)):.4f}"[1:] == mid


def test_mcnemar_is_the_binomial_test_of_the_pairs_that_differ() -> None:
    """All up to 25, at once, against SciPy. Kills: A and B swapped, twice a p-value above 1, mid-p of the wrong tail."""
    b, c = np.meshgrid(np.arange(14), np.arange(12), indexing="ij")
    found = {side: mcnemar(b, c, better=side) for side in ("either", "a", "b")}  # type: ignore[arg-type]
    half = {side: mcnemar(b, c, better=side, mid=True) for side in ("either", "a", "b")}  # type: ignore[arg-type]
    for i, j in itertools.product(range(14), range(12)):
        for side, alternative in (("either", "two-sided"), ("a", "greater"), ("b", "less")):
            expected = oracle.binomtest(i, i + j, 0.5, alternative).pvalue if i + j else 1
            assert found[side][i, j] == pytest.approx(expected, abs=1e-12)
            at = oracle.binom.pmf(i, i + j, 0.5) * (1 if side == "either" else 0.5)
            assert half[side][i, j] == pytest.approx(1 if side == "either" and i == j else expected - at, abs=1e-12)


@pytest.mark.parametrize("n", [5, 20, 61])
@pytest.mark.parametrize("alpha", [0.01, 0.05, 0.1])
def test_size_of_mcnemar_is_below_nominal(n: int, alpha: float) -> None:
    """For every number of pairs that differ; mid-p up to 1.4 alpha. Kills: mid-p called exact, a tail off by one."""
    b, law = np.arange(n + 1), oracle.binom.pmf(np.arange(n + 1), n, 0.5)
    for side in ("either", "a", "b"):
        assert law[mcnemar(b, n - b, better=side) <= alpha].sum() <= alpha + 1e-15  # type: ignore[arg-type]
        assert law[mcnemar(b, n - b, better=side, mid=True) <= alpha].sum() <= 1.4 * alpha  # type: ignore[arg-type]


@pytest.mark.parametrize("alpha", [0.01, 0.05, 0.1])
def test_e_value_of_pairs(alpha: float) -> None:
    """(10, 0) has 93.1; E[E] = 1 of equals; it ever reaches 1/alpha with <= alpha, exactly. Kills: B(b, c), 2^b for 2^(b + c)."""
    assert f"{math.exp(log_e_paired(10, 0)):.1f}" == "93.1"
    for n in (0, 1, 10, 200):
        b = np.arange(n + 1)
        assert np.exp(log_e_paired(b, n - b)) @ oracle.binom.pmf(b, n, 0.5) == pytest.approx(1, rel=1e-10)
    looks = schedule(1500)
    most = np.array(
        [int(np.count_nonzero(log_e_paired(np.arange(n // 2), n - np.arange(n // 2)) >= -math.log(alpha))) - 1 for n in looks]
    )
    found = walk(0.5, Boundary(looks, most, looks - most))
    assert 0.4 * alpha < found.passes + found.fails <= alpha
    assert np.isfinite(log_e_paired(10**6, 10**5))


def test_intervals_reproduce_published_ones() -> None:
    """Fagerland, Lydersen & Laake's (59, 6, 16, 80). Kills: phi without its correction, A and B swapped, Wald's interval."""
    for method, low, high in ((newcombe, "-0.1186", "-0.0046"), (tango, "-0.1240", "-0.0054")):
        found = method(Pairs(59, 6, 16, 80))
        assert (f"{found.value:.4f}", f"{found.low:.4f}", f"{found.high:.4f}") == ("-0.0621", low, high)
        assert "approximate" in found.method


def most_likely(only_a: int, only_b: int, n: int, difference: float) -> float:
    """P(only B) that makes the numbers most likely if P(only A) - P(only B) = difference, found by search."""
    low, high = max(0.0, -difference), (1 - difference) / 2

    def surprise(q: float) -> float:
        return -float(xlogy(only_a, q + difference) + xlogy(only_b, q) + xlogy(n - only_a - only_b, 1 - 2 * q - difference))

    return float(optimize.minimize_scalar(surprise, bounds=(low, high), method="bounded", options={"xatol": 1e-12}).x)


@pytest.mark.parametrize(
    "pairs", [Pairs(59, 6, 16, 80), Pairs(1, 1, 7, 12), Pairs(20, 5, 0, 5), Pairs(3, 9, 9, 1), Pairs(0, 30, 10, 0)]
)
@pytest.mark.parametrize("confidence", [0.8, 0.95])
def test_tangos_ends_solve_the_score_equation(pairs: Pairs, confidence: float) -> None:
    """With the constrained likelihood maximised by search. Kills: the unconstrained variance, a wrong sign in the square root."""
    found, z = tango(pairs, confidence), oracle.norm.ppf((1 + confidence) / 2)
    for end, expected in ((found.low, z), (found.high, -z)):
        q = most_likely(pairs.only_a, pairs.only_b, pairs.n, end)
        variance = pairs.n * (2 * q + end - end**2)
        assert (pairs.only_a - pairs.only_b - pairs.n * end) / math.sqrt(variance) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("method", "least"), [(newcombe, 0.935), (tango, 0.925)])
@pytest.mark.parametrize("n", [10, 30])
def test_coverage_of_the_difference_summed_over_all_tables(method: object, least: float, n: int) -> None:
    """Nearly 95 % for 47 laws, and on average at least. Kills: phi of the wrong sign, one end for the other."""
    found = [method(Pairs(*table)) for table in tables(n).tolist()]  # type: ignore[operator]
    low, high = np.array([one.low for one in found]) - 1e-12, np.array([one.high for one in found]) + 1e-12
    held = [likelihood(n, cells)[(low <= (d := cells[1] - cells[2])) & (d <= high)].sum() for cells in LAWS]
    assert len(held) == 47
    assert min(held) >= least
    assert 0.95 <= np.mean(held) <= 0.99


def test_intervals_turn_with_the_designs_and_enclose_what_was_seen() -> None:
    """Kills: an end of A's interval used for B's."""
    for table in tables(7).tolist():
        for method in (newcombe, tango):
            found, turned = method(Pairs(*table)), method(Pairs(table[0], table[2], table[1], table[3]))
            assert -1 <= found.low <= found.value <= found.high <= 1
            assert (turned.low, turned.high) == pytest.approx((-found.high, -found.low), abs=1e-12)


@pytest.mark.parametrize("margin", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("alpha", [0.025, 0.05])
def test_noninferiority_is_the_lower_end_of_tangos_interval(margin: float, alpha: float) -> None:
    """p <= alpha iff the interval at 1 - 2 alpha lies above -margin; its size stays within half of alpha more.

    Kills: a margin of the wrong sign, two-sided for one-sided.
    """
    n, rejected = 20, []
    for table in tables(n).tolist():
        pairs = Pairs(*table)
        p, low = noninferiority(pairs, margin), tango(pairs, 1 - 2 * alpha).low
        assert abs(low + margin) < 1e-9 or (p <= alpha) == (low > -margin)
        rejected.append(p <= alpha)
    for apart in (margin, margin + 0.02, margin + 0.1, margin + 0.3):
        only_a = (apart - margin) / 2
        cells = np.array([1 - apart, only_a, only_a + margin, 0])
        assert likelihood(n, cells)[rejected].sum() <= 1.5 * alpha


def test_pairs_are_counted_by_what_succeeded() -> None:
    """Kills: the two in the middle swapped."""
    found = pairs_of([1, 1, 1, 0, 0, 1], [1, 1, 0, 1, 0, 0])
    assert found == Pairs(both=2, only_a=2, only_b=1, neither=1)
    assert found.n == 6
    with pytest.raises(ValueError, match="the same shape"):
        pairs_of([True], [True, False])


def test_no_pairs_say_nothing() -> None:
    """Kills: a division by zero."""
    nothing = Pairs(0, 0, 0, 0)
    for found in (newcombe(nothing), tango(nothing)):
        assert math.isnan(found.value)
        assert (found.low, found.high, found.n) == (-1, 1, 0)
    assert noninferiority(nothing, 0.1) == 1
    assert quantile_shift([], [], 0.5, rng=np.random.default_rng(0)).high == math.inf
    assert mcnemar(0, 0) == 1
    assert tango(Pairs(5, 0, 0, 0)).low < 0 < tango(Pairs(5, 0, 0, 0)).high


def test_impossible_arguments_are_refused() -> None:
    """Kills: a check that is left out."""
    with pytest.raises(ValueError, match="four whole numbers"):
        newcombe(Pairs(1, -1, 0, 0))
    with pytest.raises(ValueError, match="four whole numbers"):
        tango(Pairs(1, 1.5, 0, 0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="margin must be between"):
        noninferiority(Pairs(1, 1, 1, 1), 0)
    with pytest.raises(ValueError, match='better must be "either", "a" or "b"'):
        mcnemar(1, 2, better="c")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="must be pairs"):
        quantile_shift([1], [1, 2], 0.5, rng=np.random.default_rng(0))


def test_a_quantile_shift_keeps_the_pairs() -> None:
    """b is a moved by 3, in its own order: 3, exactly and in every resample. Kills: rows drawn apart, a - b."""
    a = oracle.lognorm.ppf((np.arange(200) + 0.5) / 200, 1)[np.random.default_rng(5).permutation(200)]
    found = quantile_shift(a, a + 3, 0.9, rng=np.random.default_rng(1))
    assert (found.value, found.low, found.high) == pytest.approx((3, 3, 3), abs=1e-9)
    assert "approximate" in found.method


def test_a_quantile_shift_agrees_with_a_general_bootstrap() -> None:
    """SciPy's paired one, other numbers. Kills: twice the risk, the median for q, ends swapped."""
    grid = (np.arange(300) + 0.5) / 300
    a, b = oracle.norm.ppf(grid), oracle.norm.ppf(grid[np.random.default_rng(5).permutation(300)], 0.4, 1.5)

    def apart(x: NDArray[np.float64], y: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
        return np.subtract(*(np.quantile(one, 0.8, axis=axis, method="inverted_cdf") for one in (y, x)))

    reference = oracle.bootstrap((a, b), apart, paired=True, method="percentile", n_resamples=4000, rng=np.random.default_rng(3))
    found = quantile_shift(a, b, 0.8, rng=np.random.default_rng(4), resamples=4000)
    low, high = reference.confidence_interval
    assert found.value == pytest.approx(float(apart(a, b, 0)), abs=1e-12)
    assert (found.low, found.high) == pytest.approx((low, high), abs=0.05 * (high - low))
    assert found == quantile_shift(a, b, 0.8, rng=np.random.default_rng(4), resamples=4000)


def test_what_never_settled_is_the_worst() -> None:
    """NaN is the worst value; inf - inf could be anything. Kills: dropping it, NaN sorted as one of both ends."""
    good, bad = np.arange(40.0), np.where(np.arange(40) % 2, math.nan, np.arange(40.0))
    found = quantile_shift(good, bad, 0.9, rng=np.random.default_rng(0))
    assert (found.value, found.low, found.high) == (math.inf, math.inf, math.inf)
    both = quantile_shift(bad, bad, 0.9, rng=np.random.default_rng(0))
    assert math.isnan(both.value)
    assert (both.low, both.high) == (-math.inf, math.inf)
