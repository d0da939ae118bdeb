"""Log-normal, triangular, beta, exponential, Weibull and Poisson laws, directions about a mean, rotations: against SciPy's
own, 60-digit arithmetic and closed forms.

False alarms: every Kolmogorov–Smirnov test is at 1e-6 with a fixed stream; together below 2e-5.
"""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from rvjax.campaign.distributions import (
    Attitude,
    Ball,
    Beta,
    Direction,
    Distribution,
    Exponential,
    HalfNormal,
    LogNormal,
    LogUniform,
    Normal,
    Poisson,
    Triangular,
    TruncatedNormal,
    Uniform,
    VonMisesFisher,
    Weibull,
)
from rvjax.stats.random_streams import uniforms

U = np.concatenate((2.0 ** -np.arange(1.0, 54.0), 1.0 - 2.0 ** -np.arange(2.0, 53.0), np.linspace(0.001, 0.999, 999)))

PAIRS: list[tuple[Distribution, Any]] = [
    (LogNormal(3.0, 0.4), stats.lognorm(0.4, 0.0, 3.0)),
    (Triangular(-1.0, 0.5, 5.0), stats.triang(0.25, -1.0, 6.0)),
    (Triangular(2.0, 2.0, 4.0), stats.triang(0.0, 2.0, 2.0)),
    (Triangular(2.0, 4.0, 4.0), stats.triang(1.0, 2.0, 2.0)),
    (Beta(2.0, 5.0, -3.0, 7.0), stats.beta(2.0, 5.0, -3.0, 10.0)),
    (Beta(0.5, 0.5, 0.0, 1.0), stats.beta(0.5, 0.5)),
    (Exponential(50.0), stats.expon(0.0, 50.0)),
    (Weibull(50.0, 0.7), stats.weibull_min(0.7, 0.0, 50.0)),
    (Weibull(50.0, 3.0), stats.weibull_min(3.0, 0.0, 50.0)),
]
IDS = [repr(ours) for ours, _ in PAIRS]


@pytest.mark.parametrize(("ours", "theirs"), PAIRS, ids=IDS)
def test_law_is_that_of_scipy(ours: Distribution, theirs: Any) -> None:
    """Kills: mean for median, rate for mean, shape and scale swapped, the mode as a share, a width for the high end."""
    np.testing.assert_allclose(ours.ppf(U), theirs.ppf(U), rtol=1e-11, atol=1e-13)
    x = np.concatenate((ours.ppf(U), [-1e3, 0.0, 1e3]))
    np.testing.assert_allclose(ours.cdf(x), theirs.cdf(x), rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("ours", [*(ours for ours, _ in PAIRS), Poisson(3.5)], ids=[*IDS, "Poisson"])
def test_support_and_scale(ours: Distribution) -> None:
    """Every draw is inside [low, high]; k·X has the inverse k·F⁻¹. Kills a parameter that is forgotten in scaling."""
    drawn = ours.ppf(U)
    assert (drawn >= ours.low).all()
    assert (drawn <= ours.high).all()
    np.testing.assert_allclose(ours.scaled(0.25).ppf(U), 0.25 * drawn, rtol=1e-12)
    np.testing.assert_allclose(ours.scaled(0.25).cdf(0.25 * drawn), ours.cdf(drawn), rtol=1e-12)
    assert ours.scaled(0.25).high == pytest.approx(0.25 * ours.high)


def _beta_tail(a: float, b: float, z: Any) -> Any:
    return mpmath.betainc(a, b, 0, z, regularized=True)


EXACT: dict[str, tuple[Distribution, Any, Any, float]] = {
    "log-normal": (
        LogNormal(3.0, 0.4),
        lambda x: mpmath.ncdf(mpmath.log(x / 3) / mpmath.mpf(0.4)),
        lambda x: mpmath.ncdf(-mpmath.log(x / 3) / mpmath.mpf(0.4)),
        0.0,
    ),
    "triangular": (
        Triangular(0.0, 1.0, 4.0),
        lambda x: x * x / 4 if x < 1 else 1 - (4 - x) ** 2 / 12,
        lambda x: 1 - x * x / 4 if x < 1 else (4 - x) ** 2 / 12,
        4.0,
    ),
    "beta": (
        Beta(2.0, 3.0, -1.0, 0.0),
        lambda x: _beta_tail(2, 3, 1 + x),
        lambda x: _beta_tail(3, 2, -x),
        -1.0,
    ),
    "exponential": (Exponential(50.0), lambda x: -mpmath.expm1(-x / 50), lambda x: mpmath.exp(-x / 50), 0.0),
    "weibull": (
        Weibull(50.0, 2.0),
        lambda x: -mpmath.expm1(-((x / 50) ** 2)),
        lambda x: mpmath.exp(-((x / 50) ** 2)),
        0.0,
    ),
}


@pytest.mark.parametrize("name", EXACT)
def test_tails_keep_their_digits(name: str) -> None:
    """F(F⁻¹(u)) = u below the middle and 1 − F(F⁻¹(u)) = 1 − u above it, each relatively, in 60 digits: to what the rounding of
    x can do (and, at an end that is not 0, of x − end; and of Φ⁻¹(u), whose last digit is ten last digits of F in a tail). Kills
    log(1 − u) for log1p(−u), z = F⁻¹(u) where 1 − z counts.
    """
    ours, below, above, end = EXACT[name]
    u = np.array([2.0**-54, 1e-13, 1e-6, 0.01, 0.3, 0.5, 0.7, 0.99, 1.0 - 1e-6, 1.0 - 1e-13, 1.0 - 2.0**-53])
    x = ours.ppf(u)
    with mpmath.workdps(60):
        for share, value in zip(u.tolist(), map(mpmath.mpf, x.tolist()), strict=True):
            tail, target = (below, mpmath.mpf(share)) if share < 0.5 else (above, 1 - mpmath.mpf(share))
            off = abs(tail(value) / target - 1)
            allowed = 120 * 2.0**-53 * (float(max(1, end / (end - value))) if end else 1.0)
            assert off < allowed, (share, float(value), float(off))


@pytest.mark.parametrize("mean", [0.02, 3.5, 700.0])
def test_poisson_is_the_smallest_count_that_reaches_u(mean: float) -> None:
    """F(k − 1) < u ≤ F(k) in 60 digits, in both tails and beside every step. Kills the wrong side of a step, a table that ends
    too early, and 1 − F from F in the upper tail."""
    steps = stats.poisson(mean).cdf(np.arange(0, int(mean + 8 * math.sqrt(mean) + 8)))
    beside = np.concatenate((np.nextafter(steps[::7], 0.0), np.nextafter(steps[::7], 2.0)))
    u = np.unique(np.clip(np.concatenate((U[:104], beside)), 2.0**-54, 1.0 - 2.0**-53))
    counts = Poisson(mean).ppf(u)
    assert (counts == np.floor(counts)).all()
    k = np.arange(max(0.0, mean - 3 * math.sqrt(mean)), mean + 3 * math.sqrt(mean) + 2).round()
    with mpmath.workdps(40):
        below = np.array([float(mpmath.gammainc(int(j) + 1, mean, regularized=True)) for j in k])  # F(k), rounded
        above = np.array([float(mpmath.gammainc(int(j) + 1, 0, mean, regularized=True)) for j in k])  # 1 − F(k), rounded
    left = below < 0.5
    np.testing.assert_array_equal(Poisson(mean).ppf(below[left]), k[left])
    right = (1.0 - above > 0.5) & (1.0 - (1.0 - above) == above)
    np.testing.assert_array_equal(Poisson(mean).ppf(1.0 - above[right]), k[right])
    np.testing.assert_allclose(Poisson(mean).cdf(counts), stats.poisson(mean).cdf(counts), rtol=1e-12)
    with mpmath.workdps(60):
        for share, k in list(zip(u.tolist(), counts.tolist(), strict=True))[:: max(1, len(u) // 40)]:
            below = mpmath.gammainc(k, mean, regularized=True) if k else mpmath.mpf(0)  # F(k − 1)
            reached = mpmath.gammainc(k + 1, mean, regularized=True)
            slack = 1e-13 * min(share, 1.0 - share)  # what the tabulated F may be off by
            assert below - slack < share <= reached + slack, (share, k)


ALL: list[Distribution] = [
    *(ours for ours, _ in PAIRS),
    Uniform(-3.0, 5.0),
    Normal(2.0, 0.5),
    TruncatedNormal(100.0, 10.0, 80.0, 105.0),
    LogUniform(1e-3, 1e2),
    HalfNormal(3.0),
]


@pytest.mark.parametrize("ours", ALL, ids=repr)
def test_draws_have_the_law(ours: Distribution) -> None:
    """Kolmogorov–Smirnov on 20,000 draws at a false-alarm rate of 1e-6. Kills a law that uses a stream's wrong column."""
    drawn = ours.ppf(uniforms(3, repr(ours), np.arange(20_000))[:, 0])
    assert stats.kstest(drawn, ours.cdf).pvalue > 1e-6


def test_counts_have_the_law() -> None:
    """Pearson's χ² on 20,000 draws of a Poisson law at a false-alarm rate of 1e-6."""
    drawn = Poisson(3.5).ppf(uniforms(3, "count", np.arange(20_000))[:, 0])
    found = np.bincount(np.minimum(drawn, 12).astype(int), minlength=13)
    mass = stats.poisson(3.5).pmf(np.arange(13))
    mass[12] = stats.poisson(3.5).sf(11)
    assert stats.chisquare(found, 20_000 * mass).pvalue > 1e-6


@pytest.mark.parametrize("kappa", [1e-3, 2.0, 400.0, 1e9])
@pytest.mark.parametrize("mean", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, -2.0, 0.5)])
def test_directions_about_a_mean(kappa: float, mean: tuple[float, float, float]) -> None:
    """1 − cos of the angle to the mean has F(t) = (1 − e^(−κt))/(1 − e^(−2κ)), the azimuth is uniform (Kolmogorov–
    Smirnov at 1e-6).

    Kills cosh for sinh, an azimuth about the z axis, a frame that breaks at −z, and 1 − cos by subtraction at large κ."""
    law = VonMisesFisher.of(mean, kappa, 3.0)
    points = law.ppf(uniforms(5, f"{kappa}{mean}", np.arange(20_000)))
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 3.0, rtol=1e-12)
    axis = np.array(mean) / np.linalg.norm(mean)
    across = points / 3.0 - np.outer(points @ axis / 3.0, axis)
    sine = np.linalg.norm(across, axis=1)
    t = np.where(points @ axis > 0.0, sine**2 / (1.0 + np.sqrt(np.maximum(1.0 - sine**2, 0.0))), 1.0 - points @ axis / 3.0)
    share = np.expm1(-kappa * t) / np.expm1(-2.0 * kappa)
    assert stats.kstest(share, "uniform").pvalue > 1e-6
    first = np.cross(axis, [0.3, 0.9, -0.4])
    first /= np.linalg.norm(first)
    azimuth = np.arctan2(across @ np.cross(axis, first), across @ first)
    assert stats.kstest((azimuth / (2.0 * math.pi)) % 1.0, "uniform").pvalue > 1e-6
    assert law.scaled(2.0).ppf([[0.3, 0.6]]) == pytest.approx(2.0 * law.ppf([[0.3, 0.6]]))


def test_rotations_are_uniform() -> None:
    """The angle has F = (θ − sin θ)/π, and a rotation behind it changes nothing: each entry of R and of RQ is uniform on
    [−1, 1].
    Kolmogorov–Smirnov at 1e-6. Kills a uniform angle about a uniform axis, MRP in a ball, half of SO(3) left out."""
    sigma = Attitude().ppf(uniforms(5, "attitude", np.arange(20_000)))
    assert np.linalg.norm(sigma, axis=1).max() <= 1.0 + 1e-15
    turns = Rotation.from_mrp(sigma)
    angle = turns.magnitude()
    assert stats.kstest((angle - np.sin(angle)) / math.pi, "uniform").pvalue > 1e-6
    for matrices in (turns.as_matrix(), (turns * Rotation.from_rotvec([0.7, -1.1, 0.4])).as_matrix()):
        for entry in matrices.reshape(-1, 9).T:
            assert stats.kstest((entry + 1.0) / 2.0, "uniform").pvalue > 1e-6


def test_joint_draws_depend_on_every_uniform_number() -> None:
    """Kills a law that says it consumes more numbers than it does, or reads one twice."""
    u = np.array([[0.2, 0.3, 0.4, 0.5]])
    for law in (Direction(1.0), Ball(1.0), VonMisesFisher.of((1.0, 0.0, 0.0), 2.0, 1.0), Attitude()):
        for column in range(4):
            moved = u.copy()
            moved[0, column] += 0.1
            assert np.array_equal(law.ppf(moved), law.ppf(u)) is (column >= law.uniforms)


@pytest.mark.parametrize(
    "make",
    [
        lambda: LogNormal(0.0, 0.1),
        lambda: LogNormal(1.0, 0.0),
        lambda: LogNormal(1.0, 11.0),
        lambda: Triangular(0.0, 2.0, 1.0),
        lambda: Triangular(1.0, 1.0, 1.0),
        lambda: Beta(0.0, 1.0, 0.0, 1.0),
        lambda: Beta(1.0, 1.0, 1.0, 1.0),
        lambda: Exponential(0.0),
        lambda: Weibull(1.0, 0.01),
        lambda: Weibull(-1.0, 1.0),
        lambda: Poisson(0.0),
        lambda: Poisson(1e7),
        lambda: VonMisesFisher.of((0.0, 0.0, 0.0), 1.0, 1.0),
        lambda: VonMisesFisher.of((1.0, 0.0, 0.0), 0.0, 1.0),
        lambda: VonMisesFisher.of((1.0, 0.0, 0.0), 1.0, 0.0),
    ],
)
def test_parameters_that_make_no_law(make: Any) -> None:
    with pytest.raises(ValueError):
        make()
