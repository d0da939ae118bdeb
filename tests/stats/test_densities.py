"""Densities against SciPy, and suprema of their ratios against closed forms and brute force."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import stats

from rvjax.campaign.distributions import (
    Attitude,
    Ball,
    Beta,
    Direction,
    Empirical,
    Exponential,
    Fixed,
    HalfNormal,
    LogNormal,
    LogUniform,
    Normal,
    Pick,
    Poisson,
    Triangular,
    TruncatedNormal,
    Uniform,
    VonMisesFisher,
    Weibull,
)
from rvjax.stats.densities import has_density, log_density, ratio

PAIRS: list[tuple[Any, Any]] = [
    (Uniform(-1.0, 3.0), stats.uniform(-1.0, 4.0)),
    (LogUniform(0.5, 8.0), stats.loguniform(0.5, 8.0)),
    (Triangular(-1.0, 0.5, 5.0), stats.triang(0.25, -1.0, 6.0)),
    (Triangular(2.0, 2.0, 4.0), stats.triang(0.0, 2.0, 2.0)),
    (Triangular(2.0, 4.0, 4.0), stats.triang(1.0, 2.0, 2.0)),
    (Beta(2.0, 5.0, -3.0, 7.0), stats.beta(2.0, 5.0, -3.0, 10.0)),
    (Beta(0.5, 0.5, 0.0, 1.0), stats.beta(0.5, 0.5)),
    (Normal(2.0, 3.0), stats.norm(2.0, 3.0)),
    (TruncatedNormal(1.0, 2.0, 3.0, 9.0), stats.truncnorm(1.0, 4.0, 1.0, 2.0)),
    (TruncatedNormal(1.0, 2.0, -9.0, -1.0), stats.truncnorm(-5.0, -1.0, 1.0, 2.0)),
    (TruncatedNormal(0.0, 1.0, 20.0, 25.0), stats.truncnorm(20.0, 25.0, 0.0, 1.0)),
    (HalfNormal(3.0), stats.halfnorm(0.0, 3.0)),
    (LogNormal(3.0, 0.4), stats.lognorm(0.4, 0.0, 3.0)),
    (Exponential(50.0), stats.expon(0.0, 50.0)),
    (Weibull(50.0, 0.7), stats.weibull_min(0.7, 0.0, 50.0)),
    (Weibull(50.0, 3.0), stats.weibull_min(3.0, 0.0, 50.0)),
]


@pytest.mark.parametrize(("ours", "theirs"), PAIRS, ids=[repr(ours) for ours, _ in PAIRS])
def test_density_is_that_of_scipy(ours: Any, theirs: Any) -> None:
    """Kills: a normalising constant lost, a factor of the scale lost, a density outside of the support."""
    x = ours.ppf(np.linspace(0.001, 0.999, 301))
    np.testing.assert_allclose(log_density(ours, x), theirs.logpdf(x), rtol=1e-9, atol=1e-9)
    outside = np.array([ours.low - 1.0, ours.high + 1.0])
    outside = outside[np.isfinite(outside)]
    assert np.all(log_density(ours, outside) == -np.inf)


def test_steps() -> None:
    """Kills: a density in place of a probability, counts without their unit."""
    pick = Pick.of([1.0, 2.0, 5.0], [1.0, 2.0, 1.0])
    assert np.exp(log_density(pick, np.array([1.0, 2.0, 5.0, 3.0]))) == pytest.approx([0.25, 0.5, 0.25, 0.0])
    poisson = Poisson(3.0, 0.1)
    np.testing.assert_allclose(np.exp(log_density(poisson, np.arange(9) * 0.1)), stats.poisson(3.0).pmf(np.arange(9)), rtol=1e-12)
    assert log_density(poisson, np.array([0.05]))[0] == -np.inf


def test_directions() -> None:
    """Kills: κ without its constant. The mean of the density over the sphere is 1/4π."""
    law = VonMisesFisher.of((1.0, 2.0, -1.0), 4.0, 2.0)
    points = Direction(2.0).ppf(np.random.Generator(np.random.Philox(key=1)).random((200_000, 2)))
    density = np.exp(log_density(law, points))
    assert density.mean() == pytest.approx(1.0 / (4.0 * math.pi), abs=5 * density.std() / math.sqrt(200_000))


EXACT = [
    (Uniform(80.0, 120.0), Uniform(90.0, 110.0), math.log(2.0), 0.0),
    (Uniform(80.0, 120.0), Uniform(90.0, 122.0), math.log(40.0 / 30.0), 2.0 / 32.0),
    (Normal(0.0, 1.0), Normal(0.3, 0.8), 0.3**2 / (2 * (1 - 0.8**2)) - math.log(0.8), 0.0),
    (Normal(0.0, 1.0), Normal(0.37, 0.83), 0.37**2 / (2 * (1 - 0.83**2)) - math.log(0.83), 0.0),
    (Normal(0.0, 1.0), Normal(0.0, 1.1), math.inf, 0.0),
    (Normal(0.0, 1.0), Normal(0.1, 1.0), math.inf, 0.0),
    (Normal(0.0, 1.0), Normal(0.0, 1.0), 0.0, 0.0),
    (HalfNormal(2.0), HalfNormal(1.0), math.log(2.0), 0.0),
    (Exponential(50.0), Exponential(25.0), math.log(2.0), 0.0),
    (Exponential(50.0), Exponential(51.0), math.inf, 0.0),
    (Weibull(1.0, 2.0), Weibull(1.0, 1.5), math.inf, 0.0),
    (Beta(2.0, 2.0, 0.0, 1.0), Beta(1.9, 2.0, 0.0, 1.0), math.inf, 0.0),
    (Uniform(0.0, 1.0), Triangular(0.0, 0.3, 1.0), math.log(2.0), 0.0),
    (Uniform(0.0, 2.0), Beta(3.0, 3.0, 0.0, 2.0), math.log(30.0 / 16.0), 0.0),
    (LogNormal(2.0, 0.5), LogNormal(2.0, 0.4), math.log(0.5 / 0.4), 0.0),
    (LogNormal(2.0, 0.5), LogNormal(2.0, 0.6), math.inf, 0.0),
    (Pick.of([1.0, 2.0]), Pick.of([1.0, 2.0], [3.0, 1.0]), math.log(1.5), 0.0),
    (Pick.of([1.0, 2.0]), Pick.of([1.0, 3.0], [3.0, 1.0]), math.log(2.0), 0.25),
    (Poisson(3.0), Poisson(2.0), 1.0, 0.0),
    (Poisson(3.0), Poisson(3.1), math.inf, 0.0),
    (Ball(2.0), Ball(1.0), math.log(8.0), 0.0),
    (Ball(1.0), Ball(1.01), 0.0, 1.0 - 1.01**-3),
    (Direction(2.0), VonMisesFisher.of((0.0, 0.0, 1.0), 2.0, 2.0), math.log(2.0 * 2.0 / -math.expm1(-4.0)), 0.0),
]


@pytest.mark.parametrize(("old", "new", "log_sup", "beyond"), EXACT, ids=[f"{a!r}-{b!r}" for a, b, _, _ in EXACT])
def test_the_supremum_is_exact(old: Any, new: Any, log_sup: float, beyond: float) -> None:
    """Kills: a supremum at points only, a tail that grows without bound, a part beyond that is forgotten or not divided out."""
    found = ratio(old, new)
    assert found.log_sup == pytest.approx(log_sup, rel=1e-9, abs=1e-9)
    assert found.beyond == pytest.approx(beyond, abs=1e-12)


def test_no_sample_is_above_the_supremum() -> None:
    """Kills: a maximum between the points that is missed. 60 pairs of random laws, 3,000 draws of each."""
    source = np.random.Generator(np.random.Philox(key=2))
    u = source.random(3000)

    def law() -> Any:
        a, b = np.sort(source.uniform(-2.0, 2.0, 2))
        return source.choice(
            np.array(
                [
                    Uniform(-2.5, 2.5),
                    Normal(a, 0.5 + source.random()),
                    TruncatedNormal(b, 0.2 + source.random(), -2.5, 2.5),
                    Triangular(-2.5, a, 2.5),
                    Beta(1.0 + 4 * source.random(), 1.0 + 4 * source.random(), -2.5, 2.5),
                ],
                dtype=object,
            )
        )

    bounded = 0
    for _ in range(60):
        old, new = law(), law()
        found = ratio(old, new)
        if not math.isfinite(found.log_sup):
            continue
        bounded += 1
        x = np.concatenate([old.ppf(u), new.ppf(u)])
        x = x[(x >= old.low) & (x <= old.high)]
        seen = log_density(new, x) - log_density(old, x) - math.log1p(-found.beyond)
        assert seen.max() <= found.log_sup + 1e-9
    assert bounded > 15


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (Uniform(0.0, 1.0), Fixed(0.5)),
        (Uniform(0.0, 1.0), Empirical.of([0.1, 0.2])),
        (Uniform(0.0, 1.0), Pick.of([0.1, 0.2])),
        (Attitude(), Attitude()),
        (Direction(1.0), Direction(2.0)),
        (Ball(1.0), Direction(1.0)),
        (Poisson(1.0, 1.0), Poisson(1.0, 2.0)),
    ],
)
def test_laws_without_a_ratio(old: Any, new: Any) -> None:
    """Kills: a ratio of a density and a probability."""
    with pytest.raises(TypeError):
        ratio(old, new)
    assert not has_density(Fixed(1.0))
    assert has_density(Uniform(0.0, 1.0))
