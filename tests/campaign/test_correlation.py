"""Correlated draws: the correlations that were asked for, the laws that were there before, and nothing else moved.

False alarms: each comparison with a sampling distribution is at 1e-6, on fixed seeds.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from rvjax.campaign.correlation import normal_correlation
from rvjax.components.samplers.copula import cholesky
from rvjax.errors import CampaignError
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN, SHIPPED

ALPHA = 1e-6
MASS, MOMENT, ONSET = "pursuer.mass_kg", "pursuer.inertia_kgm2.moments.x", "faults.bias.onset_s.fx"
RANK = ((1.0, 0.6, -0.3), (0.6, 1.0, 0.2), (-0.3, 0.2, 1.0))
LAWS = (
    "pursuer.mass_kg={log_normal: [100, 0.1]}",
    "pursuer.inertia_kgm2={moments: [{uniform: [20, 25]}, {uniform: [20, 25]}, {uniform: [20, 25]}]}",
    "faults.bias.onset_s={exponential: 60}",
)


def matrix(rank: tuple[tuple[float, ...], ...]) -> str:
    return str([list(row) for row in rank])


def correlate(*names: str, rank: tuple[tuple[float, ...], ...] = RANK) -> str:
    return f"correlate=[{{variables: [{', '.join(names)}], rank: {matrix(rank)}}}]"


def draws(samples: int | np.ndarray, *overrides: str) -> dict[str, np.ndarray]:
    numbers = np.arange(samples) if isinstance(samples, int) else samples
    return Draws.of(load(CAMPAIGN, [*LAWS, *overrides]), numbers)[0].values


def test_rank_correlations_are_reached() -> None:
    """Spearman's ρ of 100,000 draws within its sampling interval, in artanh ρ (Bonett and Wright's standard error).

    Kills ρ in place of 2 sin(πρ/6) (8 standard errors), L for Lᵀ, a matrix in the order of the file with names in their own."""
    drawn = draws(100_000, correlate(ONSET, MASS, MOMENT))
    order = (ONSET, MASS, MOMENT)
    limit = stats.norm.isf(ALPHA / 2)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        found = stats.spearmanr(drawn[order[i]], drawn[order[j]]).statistic
        error = math.sqrt((1.0 + RANK[i][j] ** 2 / 2.0) / (100_000 - 3))
        assert abs(math.atanh(found) - math.atanh(RANK[i][j])) < limit * error, (order[i], order[j], found)


def test_each_law_stays_what_it_is() -> None:
    """Kolmogorov–Smirnov on 20,000 draws of each. Kills a factor whose rows have not the length 1."""
    problem = load(CAMPAIGN, [*LAWS, correlate(MASS, MOMENT, ONSET)])
    values = Draws.of(problem, np.arange(20_000))[0].values
    for name in (MASS, MOMENT, ONSET):
        law = problem.dispersions.variables[name].law
        assert stats.kstest(values[name], law.cdf).pvalue > ALPHA


def test_no_other_draw_moves() -> None:
    """Bit for bit. Kills a stream that is shared, a group that takes part of another, draws that depend on the batch."""
    before = draws(500)
    pair = ((1.0, 0.6), (0.6, 1.0))
    after = draws(500, correlate(MASS, MOMENT, rank=pair))
    assert before.keys() == after.keys()
    moved = {name for name in before if not np.array_equal(before[name], after[name])}
    assert moved == {MASS}  # the first of a group keeps its own numbers
    more = draws(500, correlate(MASS, MOMENT, rank=pair), "start.nu_m_s={ball: 0.2}", "faults=[]")
    for name in (MASS, MOMENT, "start.rho_m.x"):
        np.testing.assert_array_equal(more[name], after[name], err_msg=name)
    some = draws(np.array([3, 400, 17]), correlate(MASS, MOMENT, rank=pair))
    for name, values in some.items():
        np.testing.assert_array_equal(values, after[name][[3, 400, 17]], err_msg=name)


def test_the_order_in_the_file_says_nothing() -> None:
    """Neither of variables nor of groups: the same numbers, the same fingerprint. Another matrix is another identity."""
    turned = tuple(tuple(RANK[i][j] for j in (2, 0, 1)) for i in (2, 0, 1))
    one, other = correlate(MASS, MOMENT, ONSET), correlate(ONSET, MASS, MOMENT, rank=turned)
    for name, values in draws(200, one).items():
        np.testing.assert_array_equal(draws(200, other)[name], values, err_msg=name)
    pairs = [
        f"{{variables: [{a}, {b}], rank: [[1, 0.5], [0.5, 1]]}}" for a, b in ((MASS, MOMENT), (ONSET, "faults.bias.onset_s.fy"))
    ]
    both, turned_round = (f"correlate=[{', '.join(groups)}]" for groups in (pairs, pairs[::-1]))
    assert load(CAMPAIGN, [*LAWS, one]).fingerprint == load(CAMPAIGN, [*LAWS, other]).fingerprint
    assert load(CAMPAIGN, [*LAWS, both]).fingerprint == load(CAMPAIGN, [*LAWS, turned_round]).fingerprint
    fingerprints = {
        load(CAMPAIGN, [*LAWS, *more]).fingerprint for more in ((), (one,), (both,), (pairs[0].join(("correlate=[", "]")),))
    }
    assert len(fingerprints) == 4


def test_the_factor_is_that_of_the_matrix() -> None:
    """L Lᵀ = R, L that of LAPACK; the correlation of normal numbers whose rank correlation is ½ is 2 sin(π/12)."""
    normal = normal_correlation(RANK)
    np.testing.assert_allclose(
        [[*row, *[0.0] * (3 - len(row))] for row in cholesky(normal)],
        np.linalg.cholesky(np.array(normal)),
        rtol=1e-14,
        atol=1e-16,
    )
    assert normal_correlation(((1.0, 0.5), (0.5, 1.0)))[0] == (1.0, pytest.approx(0.5176380902050415, rel=1e-15))


@pytest.mark.parametrize("campaign", sorted(SHIPPED.glob("*.yaml")), ids=lambda path: path.stem)
def test_the_variables_are_what_is_drawn(campaign: object) -> None:
    """Kills a draw that the names of a campaign cannot reach, and a name of a draw that there is not."""
    problem = load(campaign)
    drawn = Draws.of(problem, np.arange(1))[0]
    values = {name for name in drawn.values if not name.endswith((".schedule.failing", ".rejected"))}  # counted, not drawn
    assert {name for one in problem.dispersions.variables.values() for name in one.draws} == values


# --- ties and covariances ---------------------------------------------------------------------------------------------


def test_tied_draws_rise_and_fall_together() -> None:
    """Ranks are equal or reversed, without exception; the laws stay; a fourth draw keeps its correlation with all of them.

    Kills: a tie up to rounding, 1 − u for u, a tied draw that loses its law, a factor with a row too many."""
    other = "start.sigma.x"
    rank = ((1.0, 1.0, -1.0, 0.5), (1.0, 1.0, -1.0, 0.5), (-1.0, -1.0, 1.0, -0.5), (0.5, 0.5, -0.5, 1.0))
    given = correlate(MASS, ONSET, MOMENT, other, rank=rank)
    drawn = draws(5_000, given)
    order = {name: stats.rankdata(drawn[name]) for name in (MASS, ONSET, MOMENT)}
    np.testing.assert_array_equal(order[MASS], order[ONSET])
    np.testing.assert_array_equal(order[MASS], 5_001 - order[MOMENT])
    problem = load(CAMPAIGN, [*LAWS, given])
    for name in (MASS, ONSET, MOMENT, other):
        assert stats.kstest(drawn[name], problem.dispersions.variables[name].law.cdf).pvalue > ALPHA
    error = math.sqrt((1.0 + 0.125) / 4_997)
    for name, sign in ((MASS, 1.0), (ONSET, 1.0), (MOMENT, -1.0)):
        found = math.atanh(stats.spearmanr(drawn[name], drawn[other]).statistic)
        assert abs(found - sign * math.atanh(0.5)) < stats.norm.isf(ALPHA / 2) * error


def refused(*given: str) -> str:
    with pytest.raises(CampaignError) as caught:
        load(CAMPAIGN, [*LAWS, *given])
    return str(caught.value)


@pytest.mark.parametrize(
    ("rank", "words"),
    [
        (((1.0, 1.0, 0.5), (1.0, 1.0, 0.4), (0.5, 0.4, 1.0)), "variable 2 is tied to variable 1, but 0.4 in row 2 is not 0.5"),
        (((1.0, -1.0, 0.5), (-1.0, 1.0, 0.5), (0.5, 0.5, 1.0)), "0.5 in row 2 is not -0.5, as row 1 demands"),
        (((1.0, 1.0, 1.0), (1.0, 1.0, -1.0), (1.0, -1.0, 1.0)), "-1 in row 2 is not 1, as row 1 demands"),
        (((1.0, 0.9999999999), (0.9999999999, 1.0)), "accepted: correlations that can occur together; 1 or -1 ties"),
    ],
)
def test_ties_that_contradict_each_other(rank: tuple[tuple[float, ...], ...], words: str) -> None:
    """Kills: a tie that wins over the rest of the matrix silently."""
    assert words in refused(correlate(*(MASS, MOMENT, ONSET)[: len(rank)], rank=rank))


NORMAL = ("start.nu_m_s=[{normal: [1, 2]}, {normal: [0, 3]}, {normal: [0, 0.5]}]",)
RADIAN = (math.pi / 180.0) ** 2
COVARIANCE = [[4.0, 3.0, -0.4], [3.0, 9.0, 0.3], [-0.4, 0.3, 0.25]]
SPEEDS = [f"start.nu_m_s.{axis}" for axis in "xyz"]


def covariance(names: list[str], matrix: list[list[float]]) -> str:
    return f"correlate=[{{variables: [{', '.join(names)}], covariance: {matrix}}}]"


def normal_draws(*given: str) -> dict[str, np.ndarray]:
    start = "start={rho_m: 1, omega_deg_s: {normal: [0, 1]}}"
    return Draws.of(load(CAMPAIGN, [start, NORMAL[0], *given]), np.arange(50_000))[0].values


def test_a_covariance_is_reached() -> None:
    """Of 50,000 draws, each entry within its standard error √((Cᵢᵢ Cⱼⱼ + Cᵢⱼ²)/n). Kills: 2 sin(πr/6) for r, standard deviations
    for variances, names in another order than the matrix."""
    order = [2, 0, 1]
    turned = [[COVARIANCE[i][j] for j in order] for i in order]
    for given in (covariance(SPEEDS, COVARIANCE), covariance([SPEEDS[i] for i in order], turned)):
        drawn = normal_draws(given)
        found = np.cov([drawn[name] for name in SPEEDS])
        c = np.array(COVARIANCE)
        error = np.sqrt((np.outer(np.diag(c), np.diag(c)) + c**2) / 50_000)
        assert np.max(np.abs(found - c) / error) < stats.norm.isf(ALPHA / 18)


def test_a_covariance_makes_the_draws_jointly_normal() -> None:
    """The draws are L z of the independent draws z, C = L Lᵀ by LAPACK. Kills: 2 sin(πr/6) for r, which a covariance does
    not notice."""
    means = np.array([1.0, 0.0, 0.0])[:, None]
    plain, found = (
        np.array([drawn[name] for name in SPEEDS]) - means
        for drawn in (normal_draws(), normal_draws(covariance(SPEEDS, COVARIANCE)))
    )
    z = plain / np.array([2.0, 3.0, 0.5])[:, None]
    np.testing.assert_allclose(found, np.linalg.cholesky(np.array(COVARIANCE)) @ z, atol=1e-9)


def test_a_covariance_ties_draws() -> None:
    """A correlation that is −1 up to rounding, here −0.9999999999999999, is a tie: one draw is the other's multiple.

    Kills: a matrix that is refused for its last digit."""
    laws = "start.nu_m_s=[{normal: [0, 0.9]}, {normal: [0, 0.1]}, 0]"
    r = -0.09 / math.sqrt(0.81 * 0.01)
    assert r != -1.0
    drawn = normal_draws(laws, covariance(SPEEDS[:2], [[0.81, -0.09], [-0.09, 0.01]]))
    np.testing.assert_allclose(drawn[SPEEDS[0]], -9.0 * drawn[SPEEDS[1]], atol=1e-12)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            covariance(SPEEDS[:2], [[2.0, 1.0], [1.0, 9.0]]),
            "the variance 2 of start.nu_m_s.x is not that of its law; accepted: 4,",
        ),
        (covariance(SPEEDS[:2], [[4.0, 1.0], [1.0, 9.1]]), "covariance.1.1: the variance 9.1 of start.nu_m_s.y is not that of"),
        (
            covariance(SPEEDS[:2], [[4.0, 6.1], [6.1, 9.0]]),
            "the covariance 6.1 is above 6, the product of the standard deviations",
        ),
        (covariance(SPEEDS[:2], [[4.0, 1.0], [2.0, 9.0]]), "accepted: a symmetric matrix"),
        (covariance(SPEEDS[:2], [[0.0, 0.0], [0.0, 9.0]]), "covariance.0.0: found 0.0; accepted: a variance above 0, in SI"),
        (covariance(SPEEDS[:2], COVARIANCE), "2 variables but a matrix of 3 rows"),
        (covariance([SPEEDS[0], MASS], [[4.0, 1.0], [1.0, 9.0]]), f"{MASS} is not normal, so a covariance does not decide"),
        (covariance(SPEEDS, [[4.0, 5.9, 0.9], [5.9, 9.0, -1.4], [0.9, -1.4, 0.25]]), "the matrix is not positive definite"),
        (f"correlate=[{{variables: [{SPEEDS[0]}, {SPEEDS[1]}]}}]", "neither rank nor covariance; accepted: one of them"),
        (
            f"correlate=[{{variables: [{SPEEDS[0]}, {SPEEDS[1]}], rank: [[1, 0], [0, 1]], covariance: [[4, 0], [0, 9]]}}]",
            "both rank and covariance; accepted: one of them",
        ),
    ],
)
def test_a_covariance_that_is_none(given: str, words: str) -> None:
    """Kills: a diagonal that is ignored, a law whose covariance has another meaning."""
    assert words in refused(NORMAL[0], given)


def test_a_covariance_is_in_si_and_written_with_few_digits() -> None:
    """Of rates in deg/s, in (rad/s)²; 0.1 % off is accepted, more is not. Kills: variances in the unit of the key."""
    names = ["start.omega_rad_s.x", "start.omega_rad_s.y"]
    assert normal_draws(covariance(names, [[1.0005 * RADIAN, 0.0], [0.0, RADIAN]]))
    assert "accepted: 0.000304617" in refused(
        "start={rho_m: 1, omega_deg_s: {normal: [0, 1]}}", covariance(names, [[1.0, 0.0], [0.0, 1.0]])
    )


def test_rank_and_covariance_are_two_identities() -> None:
    """The same correlations mean other draws. Kills: a fingerprint of the matrix alone."""
    rank = correlate(*SPEEDS[:2], rank=((1.0, 0.5), (0.5, 1.0)))
    forms = (rank, covariance(SPEEDS[:2], [[4.0, 3.0], [3.0, 9.0]]), covariance(SPEEDS[:2], [[4.0, 3.1], [3.1, 9.0]]))
    assert len({load(CAMPAIGN, [NORMAL[0], given]).fingerprint for given in forms}) == 3
