"""Bodies that exist: what is accepted, what is drawn again and what that does to the laws; the centre of mass.

False alarms: each comparison with a sampling distribution is at 1e-6, on fixed seeds.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from rvjax.campaign.inertia_validity import about_centre, definite, physical
from rvjax.simulation.draws import Draws
from rvjax.simulation.inertia import bodies
from rvjax.simulation.problem import load
from tests.campaign.test_draws import full
from tests.short import CAMPAIGN

ALPHA = 1e-6
INERTIA = "pursuer.inertia_kgm2"
FLAT = "pursuer.inertia_kgm2={principal: [10, 10, {uniform: [15, 25]}], reject: true}"
"""J₃ of more than 20 kg·m² is no body's: half of the draws."""

WIDE = (
    "pursuer.inertia_kgm2={moments: [{normal: [20, 4]}, {normal: [20, 4]}, {normal: [30, 6]}], products: {normal: [0, 3]}, "
    "reject: true}",
    "pursuer.centre_of_mass_m={normal: [0, 0.1]}",
    "pursuer.mass_kg={log_normal: [100, 0.2]}",
    "correlate=[{variables: [pursuer.mass_kg, pursuer.inertia_kgm2.moments.z], rank: [[1, 0.7], [0.7, 1]]}]",
)


def draws(samples: int | np.ndarray, *overrides: str) -> tuple[Draws, object]:
    return Draws.of(load(CAMPAIGN, overrides), np.arange(samples) if isinstance(samples, int) else samples)


def margins(matrices: np.ndarray) -> np.ndarray:
    """(n,) how far J is inside what a body can have, relative to its trace; by LAPACK's eigenvalues."""
    values = np.linalg.eigvalsh(matrices)
    trace = values.sum(axis=1)
    return np.minimum(values[:, 0], trace - 2.0 * values[:, 2]) / np.abs(trace)


def test_what_is_accepted_is_what_the_eigenvalues_say() -> None:
    """300,000 symmetric matrices, a third of them bodies. Kills: the triangle inequality of the diagonal, a minor left out."""
    generator = np.random.default_rng(3)
    roots = generator.normal(size=(300_000, 3, 3)) * generator.uniform(0.2, 2.0, size=(300_000, 1, 3))
    spread = roots @ np.swapaxes(roots, 1, 2)  # Σ of a body
    trace = np.trace(spread, axis1=1, axis2=2)[:, None, None]
    matrices = trace * np.eye(3) - spread + np.where(np.arange(300_000) % 3, 1.0, 0.0)[:, None, None] * roots
    matrices = 0.5 * (matrices + np.swapaxes(matrices, 1, 2))
    entries = tuple(matrices[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)))
    margin = margins(matrices)
    clear = np.abs(margin) > 1e-10
    np.testing.assert_array_equal(physical(entries)[clear], margin[clear] > 0.0)
    assert 0.2 < (margin > 0.0).mean() < 0.8
    assert physical((10.0, 10.0, 20.0, 0.0, 0.0, 0.0))  # flat
    assert not physical((10.0, 10.0, 20.0 + 1e-9, 0.0, 0.0, 0.0))
    assert not physical((0.0, 10.0, 10.0, 0.0, 0.0, 0.0))  # a needle, which no torque about its axis could turn
    assert not definite((1.0, -1.0, -1.0, 0.0, 0.0, 0.0))


def test_a_million_bodies_exist(request: pytest.FixtureRequest) -> None:
    """A tenth of them by default. Moments, products, mass and centre of mass normal and correlated, many draws impossible; every
    inertia about the centre of mass by LAPACK. Kills: a draw that is clamped or kept, a check of J about the reference point."""
    problem = load(CAMPAIGN, WIDE)
    samples = np.arange(1_000_000 if request.config.getoption("--long") else 100_000)
    points, rejected = problem.dispersions.at(samples)
    pursuer, _ = bodies(problem.spec)
    inertia = pursuer.drawn(lambda name, quantity: quantity.draw(name, points.uniforms, len(samples)))
    margin = margins(full(inertia))
    assert margin.min() > -1e-11
    counts = rejected[f"{INERTIA}.rejected"]
    assert 0.2 < (counts > 0).mean() < 0.8
    again = counts.mean() / (1.0 + counts.mean())  # of a geometric law, whatever the sample
    error = np.sqrt(again * (1.0 - again) / len(samples))
    assert abs((counts > 0).mean() - again) < 2.0 * stats.norm.isf(ALPHA / 2) * error


def test_draws_are_those_of_the_law_given_that_the_body_exists() -> None:
    """J₃ is uniform on [15, 20] and rejected n times with probability 2^−(n+1): Kolmogorov–Smirnov and χ² on 20,000 draws.

    Kills: a clamped draw (an atom at 20), numbers of the first draw used again, a count that is one too high."""
    whole, _ = draws(20_000, FLAT)
    drawn, counts = whole.values[f"{INERTIA}.principal.z"], whole.values[f"{INERTIA}.rejected"]
    assert stats.kstest(drawn, stats.uniform(15.0, 5.0).cdf).pvalue > ALPHA
    found = np.bincount(np.minimum(counts, 8), minlength=9)
    expected = 20_000 * np.array([*(0.5 ** np.arange(1, 9)), 0.5**8])
    assert stats.chisquare(found, expected).pvalue > ALPHA
    assert counts.dtype == np.int64
    assert whole.columns[f"{INERTIA}.rejected"].unit == "1"
    for times in (1, 2):
        assert stats.kstest(drawn[counts == times], stats.uniform(15.0, 5.0).cdf).pvalue > ALPHA


@pytest.mark.parametrize("other", ["pursuer.mass_kg", "actuators.spread.upper.fx"])
def test_what_goes_with_a_rejected_body_is_drawn_again_with_it(other: str) -> None:
    """The law of another number given that the body exists, against a plain simulation of the copula: two-sample
    Kolmogorov–Smirnov. One name comes before that of the moment, which then is made of both numbers, and one behind.

    Kills: moments drawn again for the number that there was, which keeps that one's own law and breaks the correlation."""
    pair = f"correlate=[{{variables: [{other}, pursuer.inertia_kgm2.principal.z], rank: [[1, 0.8], [0.8, 1]]}}]"
    whole, _ = draws(20_000, FLAT, "pursuer.mass_kg={uniform: [0.9, 1.1]}", "actuators.spread={uniform: [0.9, 1.1]}", pair)
    r = 2.0 * np.sin(np.pi * 0.8 / 6.0)
    x = np.random.default_rng(5).multivariate_normal([0.0, 0.0], [[1.0, r], [r, 1.0]], 60_000)
    number, moment = 0.9 + 0.2 * stats.norm.cdf(x[:, 0]), 15.0 + 10.0 * stats.norm.cdf(x[:, 1])
    exists = moment <= 20.0
    assert stats.ks_2samp(whole.values[other], number[exists]).pvalue > ALPHA
    found = stats.spearmanr(whole.values[other], whole.values[f"{INERTIA}.principal.z"]).statistic
    expected = stats.spearmanr(number[exists], moment[exists]).statistic
    assert abs(np.arctanh(found) - np.arctanh(expected)) < 5.0 * np.sqrt(1.2 * (1 / 20_000 + 1 / 30_000))


def test_draws_again_depend_on_seed_name_and_sample_only() -> None:
    """Kills: a draw that depends on how many of the batch were rejected; other variables that move with a rejection."""
    whole, _ = draws(2_000, *WIDE)
    some, _ = draws(np.array([1700, 3, 4, 5, 999]), *WIDE)
    for name, values in some.values.items():
        np.testing.assert_array_equal(values, whole.values[name][[1700, 3, 4, 5, 999]], err_msg=name)
    plain, _ = draws(2_000)
    for name in ("start.rho_m.x", "actuators.spread.upper.fx"):
        np.testing.assert_array_equal(whole.values[name], plain.values[name])
    more, _ = draws(2_000, *WIDE, "target.inertia_kgm2={principal: {uniform: [400, 900]}, rotation: uniform, reject: true}")
    for name, values in whole.values.items():
        np.testing.assert_array_equal(more.values[name], values, err_msg=name)
    assert more.values["target.inertia_kgm2.rejected"].max() > 0


def test_where_every_body_exists_nothing_is_drawn_again() -> None:
    """The same numbers as without `reject`."""
    given = "pursuer.inertia_kgm2={{principal: [{{uniform: [17, 26]}}, 20, 23], tilt_deg: {{half_normal: 3}}{}}}"
    (plain, _), (guarded, _) = draws(500, given.format("")), draws(500, given.format(", reject: true"))
    assert guarded.values.pop(f"{INERTIA}.rejected").tolist() == [0] * 500
    assert guarded.values.keys() == plain.values.keys()
    for name, values in plain.values.items():
        np.testing.assert_array_equal(guarded.values[name], values)


def test_principal_axes_that_point_anywhere() -> None:
    """Eigenvalues are the principal moments; the axis of the largest is uniform on the sphere (heights by
    Kolmogorov–Smirnov)."""
    whole, drawn = draws(20_000, "pursuer.inertia_kgm2={principal: [10, 15, 20], rotation: uniform}")
    values, vectors = np.linalg.eigh(full(drawn.plant.inertia))
    np.testing.assert_allclose(values, np.broadcast_to([10.0, 15.0, 20.0], (20_000, 3)), rtol=1e-12)
    for axis in range(3):
        assert stats.kstest(np.abs(vectors[:, axis, 2]), "uniform").pvalue > ALPHA
    assert np.linalg.norm([whole.values[f"{INERTIA}.rotation.{axis}"] for axis in "xyz"], axis=0).max() <= 1.0 + 1e-15


def test_steiner_moves_the_inertia_to_the_centre_of_mass() -> None:
    """Of a body of five point masses, about its own centre of mass. Kills: plus for minus, c cᵀ without |c|²."""
    generator = np.random.default_rng(1)
    m, at = generator.uniform(1.0, 9.0, 5), generator.normal(size=(5, 3))

    def inertia(places: np.ndarray) -> np.ndarray:
        return np.einsum(
            "i,ijk->jk", m, (places**2).sum(axis=1)[:, None, None] * np.eye(3) - places[:, :, None] * places[:, None, :]
        )

    about, centre = inertia(at), m @ at / m.sum()
    six = tuple(about[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)))
    moved = about_centre(six, m.sum(), tuple(centre))
    expected = inertia(at - centre)
    np.testing.assert_allclose(moved, [expected[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))], rtol=1e-12)


def test_the_plant_has_the_inertia_about_its_centre_of_mass() -> None:
    """With each sample's own mass and centre; without a centre of mass the draws are what they were. Kills: the nominal mass."""
    whole, drawn = draws(300, "pursuer.centre_of_mass_m={box: [0.05, 0.1, 0]}")
    plain, before = draws(300)
    mass, (x, y) = whole.values["pursuer.mass_kg"], (whole.values[f"pursuer.centre_of_mass_m.{axis}"] for axis in "xy")
    plant, old = drawn.plant, before.plant
    np.testing.assert_array_equal(plant.centre.x, x)
    np.testing.assert_array_equal(plant.centre.z, 0.0)
    steiner = mass[:, None, None] * np.stack(
        [y * y, -x * y, 0 * x, -x * y, x * x, 0 * x, 0 * x, 0 * x, x * x + y * y], 1
    ).reshape(-1, 3, 3)
    np.testing.assert_allclose(full(plant.inertia), full(old.inertia) - steiner, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(
        full(plant.inertia_inverse) @ full(plant.inertia), np.broadcast_to(np.eye(3), (300, 3, 3)), atol=1e-12
    )
    assert np.array_equal(old.centre.x, np.zeros(300))
    for name, values in plain.values.items():
        np.testing.assert_array_equal(whole.values[name], values)


@pytest.mark.parametrize(
    ("inertia", "largest"),
    [
        ("{principal: [20, 22, 24]}", 0.3),  # Σ_xx = 13 of m x² with 100 kg, Σ_yy = 11, Σ_zz = 9: along z 0.3 m
        ("{moments: [20, 22, 24], products: 0}", 0.3),
        ("{principal: [20, 22, 24], rotation: uniform}", 0.3),
    ],
)
def test_the_farthest_centre_of_mass_is_accepted_and_no_farther_one(inertia: str, largest: float) -> None:
    """Σ_O − m c cᵀ ≥ 0 at m's upper end. Kills: the lower or the middle mass, J instead of Σ, a corner that is not looked at."""
    given = [f"pursuer.inertia_kgm2={inertia}", "pursuer.mass_kg={uniform: [50, 100]}"]
    assert load(CAMPAIGN, [*given, f"pursuer.centre_of_mass_m=[0, 0, {{uniform: [-0.1, {largest - 1e-9}]}}]"])
    with pytest.raises(Exception, match="reject: true"):
        load(CAMPAIGN, [*given, f"pursuer.centre_of_mass_m=[0, 0, {{uniform: [-0.1, {largest + 1e-6}]}}]"])
    assert load(
        CAMPAIGN, [f"pursuer.inertia_kgm2={inertia[:-1]}, reject: true}}", "pursuer.centre_of_mass_m=[0, 0, {normal: [0, 0.3]}]"]
    )
