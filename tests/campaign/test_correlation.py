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
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN

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


@pytest.mark.parametrize("campaign", sorted(CAMPAIGN.parent.glob("*.yaml")), ids=lambda path: path.stem)
def test_the_variables_are_what_is_drawn(campaign: object) -> None:
    """Kills a draw that the names of a campaign cannot reach, and a name of a draw that there is not."""
    problem = load(campaign)
    drawn = Draws.of(problem, np.arange(1))[0]
    values = {name for name in drawn.values if not name.endswith((".schedule.failing", ".rejected"))}  # counted, not drawn
    assert {name for one in problem.dispersions.variables.values() for name in one.draws} == values
