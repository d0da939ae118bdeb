"""e-processes and the ratio test: against integration, as martingales, and their exact errors under looking all the time."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats as oracle

from rvjax.stats import e_boundary, log_e_fail, log_e_pass, log_ratio, schedule, sequential, sprt_boundary, walk

GRID = [  # p0, p1, alpha, beta
    (0.5, 0.7, 0.05, 0.05),
    (0.5, 0.6, 0.1, 0.2),
    (0.7, 0.9, 0.01, 0.1),
    (0.8, 0.9, 0.05, 0.1),
    (0.9, 0.95, 0.05, 0.05),
    (0.9, 0.97, 0.1, 0.1),
    (0.95, 0.98, 0.05, 0.2),
    (0.95, 0.99, 0.01, 0.01),
    (0.99, 0.9975, 0.05, 0.1),
    (0.99, 0.999, 0.05, 0.05),
    (0.9973, 0.9995, 0.1, 0.1),
    (0.99865, 0.9999, 0.1, 0.05),
    (0.999, 0.9999, 0.05, 0.2),
]


def by_integration(n: int, failures: int, p0: float, above: bool) -> float:
    """ln E, the mixture integrated number by number in 30 digits, over angles p = sin^2 where the law is flat."""
    with mpmath.workdps(30):
        limit, s = mpmath.mpf(p0), n - failures
        edge, peak = mpmath.asin(mpmath.sqrt(limit)), mpmath.asin(mpmath.sqrt(mpmath.mpf(s) / n)) if n else mpmath.mpf(0)
        ends = (edge, mpmath.pi / 2) if above else (mpmath.mpf(0), edge)
        spread = 1 / mpmath.sqrt(4 * n + 1)
        around = {mpmath.mpf(end) + sign * k * spread for end in (*ends, peak) for sign in (-1, 1) for k in (0, 1, 3, 8, 20, 60)}
        points = sorted({*ends, *(x for x in around if ends[0] < x < ends[1])})

        def ratio(angle: mpmath.mpf) -> mpmath.mpf:
            p = mpmath.sin(angle) ** 2
            return (p / limit) ** s * ((1 - p) / (1 - limit)) ** failures

        return float(mpmath.log(mpmath.quad(ratio, points) / (ends[1] - ends[0])))


@pytest.mark.parametrize(
    ("n", "failures", "p0"),
    [
        (0, 0, 0.9),
        (1, 0, 0.5),
        (10, 3, 0.9),
        (377, 0, 0.99),
        (500, 20, 0.95),
        (2210, 0, 0.99865),
        (3000, 900, 0.99),
        (4000, 3999, 0.5),
    ],
)
def test_e_is_the_mixture_of_likelihood_ratios(n: int, failures: int, p0: float) -> None:
    """Beyond the smallest double too. Kills: Beta(1, 1), a prior over all p, s and f swapped."""
    assert float(log_e_pass(n, failures, p0)) == pytest.approx(by_integration(n, failures, p0, True), rel=1e-9, abs=1e-9)
    assert float(log_e_fail(n, failures, p0)) == pytest.approx(by_integration(n, failures, p0, False), rel=1e-9, abs=1e-9)


def test_a_million_samples_do_not_overflow() -> None:
    """Tails far below the smallest double, and just at it. Kills: no fraction, one without its even terms."""
    failures = np.array([0, 9000, 10_000, 11_000, 13_900, 20_000, 100_000, 500_000, 1_000_000])
    up, down = log_e_pass(10**6, failures, 0.99), log_e_fail(10**6, failures, 0.99)
    assert np.isfinite(up).all()
    assert np.isfinite(down).all()
    assert np.all(np.diff(up) < 0)
    assert np.all(np.diff(down) > 0)
    with mpmath.workdps(60):
        for f, found in zip(failures[4:8].tolist(), up[4:8].tolist(), strict=True):
            a, b, q = f + mpmath.mpf("0.5"), 10**6 - f + mpmath.mpf("0.5"), mpmath.mpf(0.01)
            series, term, k = mpmath.mpf(0), mpmath.mpf(1), 0  # I_q(a, b) a B(a, b) / (q^a (1 - q)^b) by its power series
            while term > series * mpmath.mpf(10) ** -25:
                series, term, k = series + term, term * q * (a + b + k) / (a + 1 + k), k + 1
            prior = mpmath.betainc(0.5, 0.5, 0, q)
            expected = mpmath.log(series * mpmath.sqrt(q * (1 - q)) / (a * prior))
            assert found == pytest.approx(float(expected), rel=1e-10)


@pytest.mark.parametrize(("a", "b", "x"), [(2.5, 3.5, 0.2), (10.5, 40.5, 0.1), (200.5, 3.5, 0.5), (4.5, 900.5, 0.001)])
def test_the_fraction_is_that_of_the_incomplete_beta(a: float, b: float, x: float) -> None:
    """Where it needs many terms, which no e-process does. Kills: a term with another sign or index, a fraction cut short."""
    found = sequential._log_fraction(np.array([a]), np.array([b]), x)
    with mpmath.workdps(30):
        expected = mpmath.log(mpmath.betainc(a, b, 0, x) * a / (mpmath.mpf(x) ** a * (1 - mpmath.mpf(x)) ** b))
    assert found == pytest.approx(float(expected), rel=1e-13)


@pytest.mark.parametrize(("n", "p0"), [(1, 0.5), (7, 0.9), (60, 0.95), (377, 0.99), (2000, 0.99)])
def test_e_is_fair_at_its_limit_and_loses_beyond(n: int, p0: float) -> None:
    """E[E] = 1 at p0, <= 1 for what PASS (FAIL) would be wrong of. Kills: any factor, a mixture over the wrong side."""
    failures = np.arange(n + 1)

    def expected(log_e: NDArray[np.float64], p: float) -> float:
        return float(np.exp(log_e + oracle.binom.logpmf(failures, n, 1 - p)).sum())

    up, down = log_e_pass(n, failures, p0), log_e_fail(n, failures, p0)
    assert [expected(up, p0), expected(down, p0)] == pytest.approx([1, 1], rel=1e-9)
    assert expected(up, p0 * 0.95) < 1
    assert expected(down, 1 - (1 - p0) * 0.95) < 1


def test_published_numbers() -> None:
    """Zero-failure stops and log E. Kills: ln 20 for ln 10, a stop one sample late."""
    assert f"{float(log_e_pass(377, 0, 0.99)):.6f}" == "2.996743"
    for p0, alpha, n in ((0.95, 0.05, 74), (0.99, 0.05, 377), (0.99865, 0.1, 2210)):
        found = e_boundary(schedule(n), p0, alpha)
        assert found.passes.tolist() == [-1] * (n - 1) + [0]


def test_type_1_error_up_to_5000_samples() -> None:
    """.04075 at .99/.05, looked at after every sample. Kills: a boundary off by one failure, alpha / 2."""
    found = e_boundary(schedule(5000), 0.99, 0.05)
    assert f"{walk(0.99, found._replace(fails=found.looks + 1)).passes:.5f}" == "0.04075"


@pytest.mark.parametrize(("p0", "p1", "alpha", "beta"), GRID)
@pytest.mark.parametrize("every", [1, 130])
def test_errors_of_the_e_process_are_below_nominal(p0: float, p1: float, alpha: float, beta: float, every: int) -> None:
    """P(PASS) at p0 and below, P(FAIL) at p0 and above, up to 2000 samples. Kills: ln(1 / alpha) / 2, PASS against p1."""
    del beta
    found = e_boundary(schedule(2000, every), p0, alpha)
    alone = found._replace(fails=found.looks + 1), found._replace(passes=np.full_like(found.looks, -1))
    assert walk(p0, alone[0]).passes <= alpha
    assert walk(p0, alone[1]).fails <= alpha
    assert walk(p0 - 0.2 * (p1 - p0), found).passes <= alpha
    at_p1 = walk(p1, found)
    assert at_p1.fails <= alpha
    assert at_p1.samples <= 2000
    assert at_p1.passes + at_p1.fails + at_p1.undecided == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize(("p0", "p1", "alpha", "beta"), GRID)
@pytest.mark.parametrize("every", [1, 130])
def test_errors_of_the_ratio_test_are_below_nominal(p0: float, p1: float, alpha: float, beta: float, every: int) -> None:
    """P(PASS) at p0 <= alpha, P(FAIL) at p1 <= beta. Kills: alpha and beta swapped, Wald's bounds, floor for ceil."""
    found = sprt_boundary(schedule(3000, every), p0, p1, alpha, beta)
    bad, good = walk(p0, found), walk(p1, found)
    assert bad.passes <= alpha
    assert good.fails <= beta
    assert bad.fails > 0.85 or bad.undecided > 0
    assert good.passes > 0.75 or good.undecided > 0


def test_walds_own_bounds_exceed_alpha() -> None:
    """.0511 for .99 against .999 at 5 %; with Ville's .0485. Kills: a ratio that is rounded to the PASS side."""
    looks, alpha, beta = schedule(20_000), 0.05, 0.05
    ville = walk(0.99, sprt_boundary(looks, 0.99, 0.999, alpha, beta))
    wald = walk(0.99, sprt_boundary(looks, 0.99, 0.999, alpha / (1 - beta), beta / (1 - alpha)))
    assert (f"{wald.passes:.4f}", f"{ville.passes:.4f}") == ("0.0511", "0.0485")
    assert ville.undecided < 1e-12


@pytest.mark.parametrize(("p0", "p1", "alpha", "beta"), GRID)
def test_boundaries_are_where_the_evidence_reaches_its_limit(p0: float, p1: float, alpha: float, beta: float) -> None:
    """Every count up to 150 samples, one by one, then to 10^6. Kills: > for >=, fails read as successes, ceil for floor."""
    looks = np.arange(1, 151)
    mixed, ratio = e_boundary(looks, p0, alpha), sprt_boundary(looks, p0, p1, alpha, beta)
    enough = -math.log(alpha)
    for j, n in enumerate(looks.tolist()):
        failures = np.arange(n + 1)
        assert np.array_equal(failures <= mixed.passes[j], log_e_pass(n, failures, p0) >= enough)
        assert np.array_equal(failures >= mixed.fails[j], log_e_fail(n, failures, p0) >= enough)
        between = log_ratio(n, failures, p0, p1)
        assert np.array_equal(failures <= ratio.passes[j], between >= enough)
        assert np.array_equal(failures >= ratio.fails[j], between <= math.log(beta))
    far = np.array([1000, 30_000, 999_999, 1_000_000])
    mixed = e_boundary(far, p0, alpha)
    some = mixed.passes >= 0
    assert np.count_nonzero(some) >= 3
    assert np.all(log_e_pass(far[some], mixed.passes[some], p0) >= enough)
    assert np.all(log_e_pass(far, mixed.passes + 1, p0) < enough)
    assert np.all(log_e_fail(far, mixed.fails, p0) >= enough)
    assert np.all(log_e_fail(far, mixed.fails - 1, p0) < enough)


def test_the_ratio_is_that_of_two_binomial_laws() -> None:
    """Kills: a gain and a loss swapped, p1 against p1."""
    failures = np.arange(31)
    law = oracle.binom.logpmf
    assert log_ratio(30, failures, 0.8, 0.9) == pytest.approx(law(failures, 30, 0.1) - law(failures, 30, 0.2), abs=1e-10)


def test_impossible_arguments_are_refused() -> None:
    """Kills: a check that is left out."""
    with pytest.raises(ValueError, match="p0 must be between 0 and 1"):
        log_e_pass(3, 1, 1.0)
    with pytest.raises(ValueError, match="failures must be between 0 and n"):
        log_e_pass(3, 4, 0.5)
    with pytest.raises(ValueError, match="failures must be whole"):
        log_e_pass(3, 1.5, 0.5)
    with pytest.raises(ValueError, match="failures must be between 0 and n"):
        log_ratio(3, 4, 0.5, 0.6)
    with pytest.raises(ValueError, match="p1 must be larger than p0"):
        sprt_boundary([1], 0.9, 0.8, 0.05, 0.05)
    with pytest.raises(ValueError, match="alpha must be between 0 and 1"):
        e_boundary([1], 0.9, 5)
