"""Distributions against SciPy's own and 500-digit arithmetic; supports and parameters that make none."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from scipy import stats

from rvjax.campaign.distributions import (
    Ball,
    Direction,
    Distribution,
    Fixed,
    HalfNormal,
    LogUniform,
    Normal,
    Pick,
    TruncatedNormal,
    Uniform,
)

U = np.concatenate((2.0 ** -np.arange(1.0, 54.0), 1.0 - 2.0 ** -np.arange(2.0, 53.0), np.linspace(0.001, 0.999, 999)))

PAIRS = [
    (Uniform(-3.0, 5.0), stats.uniform(-3.0, 8.0)),
    (Normal(2.0, 0.5), stats.norm(2.0, 0.5)),
    (TruncatedNormal(100.0, 10.0, 80.0, 105.0), stats.truncnorm(-2.0, 0.5, 100.0, 10.0)),
    (LogUniform(1e-3, 1e2), stats.loguniform(1e-3, 1e2)),
    (HalfNormal(3.0), stats.halfnorm(0.0, 3.0)),
]
IDS = [type(ours).__name__ for ours, _ in PAIRS]


@pytest.mark.parametrize(("ours", "theirs"), PAIRS, ids=IDS)
def test_inverse_is_that_of_scipy(ours: Distribution, theirs: stats.rv_continuous) -> None:
    """Kills sd for variance, 1 − u for u, natural for decimal logarithm, a missing mean."""
    np.testing.assert_allclose(ours.ppf(U), theirs.ppf(U), rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize(("ours", "theirs"), PAIRS, ids=IDS)
def test_distribution_function_is_that_of_scipy_and_undoes_the_inverse(ours: Distribution, theirs: stats.rv_continuous) -> None:
    x = np.concatenate((ours.ppf(U), [-1e3, 0.0, 1e3]))
    np.testing.assert_allclose(ours.cdf(x), theirs.cdf(x), rtol=1e-11, atol=1e-15)
    np.testing.assert_allclose(ours.cdf(ours.ppf(U)), U, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("ours", [pair[0] for pair in PAIRS] + [Pick.of([3.0, 1.0, 2.0]), Fixed(4.0)])
def test_support_and_scale(ours: Distribution) -> None:
    """Every draw is inside [low, high]; k·X has the inverse k·F⁻¹. Kills a parameter that is forgotten in scaling."""
    drawn = ours.ppf(U)
    assert (drawn >= ours.low).all()
    assert (drawn <= ours.high).all()
    np.testing.assert_allclose(ours.scaled(0.25).ppf(U), 0.25 * drawn, rtol=1e-12)
    assert (ours.scaled(0.25).low, ours.scaled(0.25).high) == pytest.approx((0.25 * ours.low, 0.25 * ours.high))


@pytest.mark.parametrize(
    ("mean", "sd", "low", "high"),
    [(0.0, 1.0, 8.0, 9.0), (0.0, 1.0, -9.0, -8.0), (0.0, 1.0, -40.0, 0.5), (0.0, 1.0, 25.0, 40.0), (1.0, 2.0, -1.0, 4.0)],
)
def test_truncated_normal_keeps_its_digits_in_the_tails(mean: float, sd: float, low: float, high: float) -> None:
    """F at our F⁻¹(u), in 500 digits, is u. Kills Φ⁻¹(Φ(a) + u(Φ(b) − Φ(a))), which is infinite from 8.3 sd on."""
    ours = TruncatedNormal(mean, sd, low, high)
    for u in (1e-12, 1e-3, 0.25, 0.5, 0.999, 1.0 - 1e-12):
        with mpmath.workdps(500):
            a, b, x = (mpmath.mpf(float(end)) for end in (low, high, float(ours.ppf([u])[0])))
            mass = mpmath.ncdf(b, mean, sd) - mpmath.ncdf(a, mean, sd)
            share = (mpmath.ncdf(x, mean, sd) - mpmath.ncdf(a, mean, sd)) / mass
            slope = mpmath.npdf(x, mean, sd) / mass
            off = abs((share - mpmath.mpf(u)) / slope)  # in units of x
        assert off <= 4e-15 * max(1.0, abs(float(x))) * max(1.0, abs(mean)), (u, float(off))


def test_half_normal_keeps_its_digits_at_zero() -> None:
    """F⁻¹(u) → u·sd·√(π/2). Kills Φ⁻¹((1 + u)/2), which is 0 below 1e-16."""
    np.testing.assert_allclose(HalfNormal(3.0).ppf([1e-20]), 3.0 * math.sqrt(math.pi / 2.0) * 1e-20, rtol=1e-14)


def test_truncated_normal_keeps_its_digits_in_its_distribution_function() -> None:
    """Kills (Φ(z) − Φ(a))/(Φ(b) − Φ(a)) above the mean, which is 0/0 from 8.3 sd on."""
    with mpmath.workdps(60):
        mass = mpmath.ncdf(-9) - mpmath.ncdf(-10)
        expected = float((mpmath.ncdf(-9) - mpmath.ncdf(-9.25)) / mass)
    np.testing.assert_allclose(TruncatedNormal(0.0, 1.0, 9.0, 10.0).cdf([9.25]), expected, rtol=1e-12)


def test_choice_has_its_weights() -> None:
    """Exact over the unit interval: the set of u that gives a value has its weight. Kills the wrong side of a step."""
    chosen = Pick.of([30.0, 10.0, 20.0], [1.0, 2.0, 5.0])
    assert (chosen.values, chosen.weights) == ((10.0, 20.0, 30.0), (0.25, 0.625, 0.125))
    edges = np.array([0.25, np.nextafter(0.25, 1.0), 0.875, np.nextafter(0.875, 1.0), 1.0 - 2.0**-53, 2.0**-54])
    assert chosen.ppf(edges).tolist() == [10.0, 20.0, 20.0, 30.0, 30.0, 10.0]
    assert chosen.cdf([9.0, 10.0, 15.0, 20.0, 30.0]).tolist() == [0.0, 0.25, 0.25, 0.875, 1.0]
    assert Pick.of([1.0, 2.0, 3.0]).ppf((np.arange(3) + 0.5) / 3).tolist() == [1.0, 2.0, 3.0]


def _lattice(count: int, dimensions: int) -> np.ndarray:
    """Midpoints of a regular lattice over the unit cube: averages over it are those over u, to the lattice's error."""
    axes = np.meshgrid(*[(np.arange(count) + 0.5) / count] * dimensions, indexing="ij")
    return np.stack([axis.ravel() for axis in axes], axis=1)


def test_direction_is_uniform_on_the_sphere() -> None:
    """|X| = r; E X = 0, E XXᵀ = r²/3 I, E z⁴ = r⁴/5. Kills a uniform polar angle (E z² = r²/2)."""
    points = Direction(2.0).ppf(_lattice(300, 2))
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 2.0, rtol=1e-14)
    np.testing.assert_allclose(points.mean(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(points.T @ points / len(points), np.eye(3) * 4.0 / 3.0, atol=1e-4)
    np.testing.assert_allclose((points**4).mean(axis=0), 16.0 / 5.0, rtol=1e-4)


def test_ball_is_uniform_in_the_ball() -> None:
    """P(|X| ≤ s) = (s/r)³, E XXᵀ = r²/5 I. Kills a radius that is uniform or grows with the square root."""
    points = Ball(2.0).ppf(_lattice(60, 3))
    radii = np.linalg.norm(points, axis=1)
    assert radii.max() <= 2.0
    for radius in (0.5, 1.0, 1.5):
        assert (radii <= radius).mean() == pytest.approx((radius / 2.0) ** 3, abs=0.02)
    np.testing.assert_allclose(points.T @ points / len(points), np.eye(3) * 4.0 / 5.0, atol=2e-3)


@pytest.mark.parametrize(("ours", "uniforms"), [(Direction(1.0), 2), (Ball(1.0), 3)])
def test_joint_distributions_scale(ours: Direction | Ball, uniforms: int) -> None:
    u = _lattice(4, uniforms)
    assert ours.uniforms == uniforms
    np.testing.assert_allclose(ours.scaled(3.0).ppf(u), 3.0 * ours.ppf(u), rtol=1e-15)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Uniform(1.0, 1.0),
        lambda: Normal(0.0, 0.0),
        lambda: Normal(0.0, -1.0),
        lambda: TruncatedNormal(0.0, 1.0, 2.0, 1.0),
        lambda: TruncatedNormal(0.0, 1.0, 31.0, 32.0),
        lambda: LogUniform(0.0, 1.0),
        lambda: LogUniform(2.0, 1.0),
        lambda: HalfNormal(0.0),
        lambda: Pick.of([]),
        lambda: Pick.of([1.0], [0.0]),
        lambda: Pick.of([1.0, 2.0], [1.0]),
        lambda: Ball(0.0),
        lambda: Direction(-1.0),
    ],
)
def test_parameters_that_make_no_distribution(make: object) -> None:
    with pytest.raises(ValueError):
        make()
