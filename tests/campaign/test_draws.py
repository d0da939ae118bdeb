"""Draws: keyed by (seed, name, sample), and put where they belong."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from rvjax.physics.vectors import Symmetric
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from rvjax.stats import random_streams
from rvjax.stats.random_streams import uniforms
from tests.short import CAMPAIGN

MU = 3.986004418e14


def draws(samples: np.ndarray, *overrides: str) -> tuple[Draws, object]:
    """What given samples of the quickstart campaign draw."""
    return Draws.of(load(CAMPAIGN, overrides), samples)


def test_a_draw_depends_on_seed_name_and_sample_only() -> None:
    """Kills: a stream shared by two names, a counter that depends on the batch, a draw that depends on the other keys."""
    some, _ = draws(np.array([5, 6, 700, 3]))
    whole, _ = draws(np.arange(1000))
    more, _ = draws(
        np.arange(1000),
        "faults=[{use: bias, onset_s: {uniform: [30, 150]}, share: {uniform: [-0.05, 0.05]}}, "
        "{use: effectiveness, onset_s: {uniform: [30, 150]}, remaining: {uniform: [0.5, 1.0]}}]",
        "disturbances=[{use: gravity-gradient}, {use: constant, force_N: {box: 1}}]",
        "controller.gains.k1={uniform: [0.05, 0.07]}",
    )
    for name, values in whole.values.items():
        np.testing.assert_array_equal(some.values[name], values[[5, 6, 700, 3]])
        if not name.startswith("disturbances."):
            np.testing.assert_array_equal(more.values[name], values, err_msg=name)
    assert "controller.gains.k1" in more.values
    other, _ = draws(np.arange(1000), "seed=1")
    assert all(not np.array_equal(values, whole.values[name]) for name, values in other.values.items())


def test_no_two_names_share_their_numbers() -> None:
    """Kills: two parts of a plant that draw identical values. Chance of a false alarm: 73·72/2 pairs · 1000 · 2⁻⁵³ < 1e-9."""
    whole, _ = draws(np.arange(1000))
    ranks = {np.argsort(values, kind="stable").tobytes() for values in whole.values.values()}
    assert len(ranks) == len(whole.values)


def test_uniforms_are_uniform_and_independent() -> None:
    """Kolmogorov–Smirnov on each of the four columns and on a pair's correlation, at a false-alarm rate of 1e-6 in total."""
    u = uniforms(3, "some.name", np.arange(20000))
    assert u.min() > 0.0
    assert u.max() < 1.0
    for column in range(4):
        assert stats.kstest(u[:, column], "uniform").pvalue > 1e-7
    r = np.corrcoef(u.T)
    limit = stats.norm.isf(0.5e-7) / math.sqrt(20000)
    assert np.abs(r[np.triu_indices(4, 1)]).max() < limit


def test_uniforms_are_inside_the_unit_interval() -> None:
    """The largest and the smallest word there are. Kills a number that rounds to 1, whose normal number would be infinite."""
    words = np.array([2**64 - 1, 2**64 - 2**11, 0, 2**63], dtype=np.uint64)
    assert random_streams._shares(words).tolist() == [1.0 - 2.0**-53, 1.0 - 2.0**-53, 2.0**-54, 0.5 + 2.0**-54]


def test_scattered_samples_have_the_numbers_of_a_row_of_them() -> None:
    """Near each other and far apart, in any order, also twice. Kills an offset by one, a block that depends on who asks."""
    row = uniforms(1, "name", np.arange(10**9, 10**9 + 3000))
    for near in (np.arange(0, 3000, 2), np.array([2999, 0, 7, 7, 8]), np.array([5])):
        np.testing.assert_array_equal(uniforms(1, "name", 10**9 + near), row[near])
    np.testing.assert_array_equal(uniforms(1, "name", np.array([10**9 + 1, 3, 2**40]))[0], row[1])


def test_only_what_is_drawn_has_a_column_with_its_unit() -> None:
    whole, _ = draws(np.arange(3), "pursuer.mass_kg=100")
    assert "pursuer.mass_kg" not in whole.values
    assert "target.port_m.x" not in whole.values
    assert whole.columns["start.rho_m.x"].unit == "m"
    assert set(whole.columns) == set(whole.values)


def test_limits_are_nominal_times_spread_and_the_controller_gets_the_nominal_ones() -> None:
    whole, drawn = draws(np.arange(200))
    np.testing.assert_allclose(drawn.plant.upper.force.y, 4.0 * whole.values["actuators.spread.upper.fy"], rtol=1e-15)
    np.testing.assert_allclose(drawn.plant.lower.torque.z, 0.6 * whole.values["actuators.spread.lower.tz"], rtol=1e-15)
    assert set(np.unique(drawn.upper.force.y)) == {4.0}
    assert set(np.unique(drawn.lower.torque.z)) == {0.6}


def full(inertia: Symmetric) -> np.ndarray:
    """(samples, 3, 3)."""
    xx, yy, zz, yz, xz, xy = (np.asarray(part) for part in inertia.parts())
    return np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(-1, 3, 3)


def test_tilted_inertia_keeps_its_principal_moments() -> None:
    """Kills: a rotation that is none, R D R instead of R D Rᵀ, the tilt used as an MRP. Eigenvalues by LAPACK."""
    tilted = "pursuer.inertia_kgm2={principal: [{uniform: [17, 26]}, {uniform: [16, 24]}, {uniform: [18, 27]}], tilt_deg: 30}"
    whole, drawn = draws(np.arange(500), tilted)
    principal = np.stack([whole.values[f"pursuer.inertia_kgm2.principal.{axis}"] for axis in "xyz"], axis=1)
    matrices = full(drawn.plant.inertia)
    np.testing.assert_allclose(np.linalg.eigvalsh(matrices), np.sort(principal, axis=1), rtol=1e-12)
    np.testing.assert_allclose(full(drawn.plant.inertia_inverse) @ matrices, np.broadcast_to(np.eye(3), (500, 3, 3)), atol=1e-13)
    fixed = "pursuer.inertia_kgm2={principal: [20, 25, 30], tilt_deg: 30}"
    _, drawn = draws(np.arange(200), fixed)
    vectors = np.linalg.eigh(full(drawn.plant.inertia))[1]
    signs = np.sign(np.einsum("nii->ni", vectors))
    turned = vectors * signs[:, None, :]
    angle = np.degrees(np.arccos((np.trace(turned, axis1=1, axis2=2) - 1.0) / 2.0))
    np.testing.assert_allclose(angle, 30.0, rtol=1e-9)


def test_matrix_inertia_is_taken_entry_by_entry() -> None:
    _, drawn = draws(np.arange(2), "pursuer.inertia_kgm2={moments: [20, 21, 22], products: [0.1, 0.2, 0.3]}")
    np.testing.assert_array_equal(full(drawn.plant.inertia)[0], [[20, 0.3, 0.2], [0.3, 21, 0.1], [0.2, 0.1, 22]])


@pytest.mark.parametrize("anomaly", [0.0, 77.0, 200.0])
def test_the_target_starts_on_its_orbit(anomaly: float) -> None:
    """Kills: e with the wrong sign, v not perpendicular to r at perigee, a frame turned the wrong way. Vis-viva and Kepler's
    elements recovered from r and v; the attitude of T by SciPy."""
    from scipy.spatial.transform import Rotation

    mrp = np.array([0.1, -0.2, 0.3])
    axis, e = 7.2e6, 0.05
    _, drawn = draws(
        np.arange(1),
        f"target.orbit={{semi_major_axis_km: {axis / 1e3}, eccentricity: {e}, true_anomaly_deg: {anomaly}}}",
        f"target.attitude_mrp={mrp.tolist()}",
    )
    r, v = (np.array([float(part[0]) for part in x.parts()]) for x in (drawn.target.r, drawn.target.v))
    assert v @ v == pytest.approx(MU * (2.0 / np.linalg.norm(r) - 1.0 / axis), rel=1e-12)
    turn = Rotation.from_mrp(mrp)  # T's axes in the perifocal frame
    r, v = turn.apply(r), turn.apply(v)
    h = np.cross(r, v)
    np.testing.assert_allclose(np.cross(v, h) / MU - r / np.linalg.norm(r), [e, 0, 0], atol=1e-12)
    assert math.degrees(math.atan2(r[1], r[0])) % 360 == pytest.approx(anomaly, abs=1e-9)
    assert h[2] > 0
