"""Slopes of a probability over the parameters of laws, against closed forms, other weights and exact secants."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import special, stats

from rvjax.campaign.distributions.bounded import Beta, LogUniform, Triangular, Uniform
from rvjax.campaign.distributions.discrete import Poisson
from rvjax.campaign.distributions.joint import Ball, VonMisesFisher
from rvjax.campaign.distributions.normal import HalfNormal, LogNormal, Normal, TruncatedNormal
from rvjax.campaign.distributions.waiting import Exponential, Weibull
from rvjax.stats.densities import log_density
from rvjax.stats.slopes import ENDS, SMOOTH, parameters, score, slope

Values = NDArray[np.float64]

U = (np.arange(2000) + 0.5) / 2000.0

CLOSED: list[tuple[Any, str, Callable[[Values], Values]]] = [
    (Normal(2.0, 3.0), "mean", lambda x: (x - 2.0) / 9.0),
    (Normal(0.0, 3.0), "mean", lambda x: x / 9.0),
    (Normal(2.0, 3.0), "sd", lambda x: (x - 2.0) ** 2 / 27.0 - 1.0 / 3.0),
    (HalfNormal(0.5), "sd", lambda x: x**2 / 0.125 - 2.0),
    (LogNormal(2.0, 0.4), "median", lambda x: np.log(x / 2.0) / (0.16 * 2.0)),
    (LogNormal(2.0, 0.4), "sigma_log", lambda x: np.log(x / 2.0) ** 2 / 0.064 - 2.5),
    (Exponential(5.0), "mean", lambda x: x / 25.0 - 0.2),
    (Weibull(3.0, 1.5), "scale", lambda x: 1.5 * ((x / 3.0) ** 1.5 - 1.0) / 3.0),
    (Weibull(3.0, 1.5), "shape", lambda x: 1.0 / 1.5 + np.log(x / 3.0) * (1.0 - (x / 3.0) ** 1.5)),
    (Beta(2.0, 3.0, 0.0, 1.0), "a", lambda x: np.log(x) - special.digamma(2.0) + special.digamma(5.0)),
    (Beta(2.0, 3.0, 0.0, 1.0), "b", lambda x: np.log1p(-x) - special.digamma(3.0) + special.digamma(5.0)),
    (Poisson(4.0), "mean", lambda x: x / 4.0 - 1.0),
    (Triangular(0.0, 0.3, 1.0), "mode", lambda x: np.where(x < 0.3, -1.0 / 0.3, 1.0 / 0.7)),
]


@pytest.mark.parametrize("case", CLOSED, ids=lambda case: f"{type(case[0]).__name__}.{case[1]}")
def test_scores_are_their_closed_forms(case: tuple[Any, str, Callable[[Values], Values]]) -> None:
    """Kills: a step of the wrong parameter or size, one side, a wrong sign, a factor."""
    law, parameter, closed = case
    x = np.array(law.ppf(U[20:-20]))
    x = x[np.abs(x - getattr(law, "mode", np.inf)) > 1e-3]
    assert np.allclose(score(law, parameter, x), closed(x), rtol=1e-6, atol=1e-6)


def test_scores_of_the_others_have_mean_0() -> None:
    """∫ s f = 0 over the quantiles of a truncated normal law; over the sphere for κ. Kills: a law without its norm."""
    law = TruncatedNormal(1.0, 2.0, -1.0, 2.0)
    x = law.ppf((np.arange(200_000) + 0.5) / 200_000)
    for parameter in ("mean", "sd"):
        assert abs(float(np.mean(score(law, parameter, x)))) < 1e-5
    sphere = VonMisesFisher((0.0, 0.0, 1.0), 2.0, 1.0)
    cosine = np.linspace(-1.0, 1.0, 200_001)
    x = np.stack([np.sqrt(1.0 - cosine**2), 0.0 * cosine, cosine], axis=1)
    f = np.exp(log_density(sphere, x))
    assert abs(float(np.trapezoid(f * score(sphere, "kappa", x), cosine))) < 1e-6 * float(np.trapezoid(f, cosine))


def test_a_linear_failure_of_normal_draws() -> None:
    """y: x + z/2 > 3, x ~ N(1, 1.5), z ~ N(0, 1): p = Φ(−β), β = (3 − μ)/τ, τ² = σ² + 1/4; dp/dμ = φ(β)/τ and
    dp/dσ = φ(β) β σ/τ². Of 400 repeats 95 % nominal cover at least 91 % (binomial at 1e-4), and the mean has no bias.
    Kills: a score that is not centred, spreads without the root of n, slopes of the complying share."""
    rng, n = np.random.default_rng(3), 600
    tau = np.sqrt(1.5**2 + 0.25)
    beta = 2.0 / tau
    exact = {"mean": stats.norm.pdf(beta) / tau, "sd": stats.norm.pdf(beta) * beta * 1.5 / tau**2}
    for parameter, truth in exact.items():
        found = []
        for _ in range(400):
            x = rng.normal(1.0, 1.5, n)
            found.append(slope(Normal(1.0, 1.5), parameter, x, x + 0.5 * rng.normal(size=n) > 3.0, 0.95).estimate)
        values = np.array([estimate.value for estimate in found])
        assert abs(values.mean() - truth) < 5.0 * values.std() / 20.0
        covered = sum(estimate.low <= truth <= estimate.high for estimate in found)
        assert covered >= int(stats.binom.ppf(1e-4, 400, 0.94))
        assert np.mean([estimate.high - estimate.low for estimate in found]) < 4.2 * values.std()


@pytest.mark.parametrize(
    "law", [Normal(1.0, 0.5), Weibull(2.0, 1.4), Beta(2.0, 2.0, 0.0, 1.0)], ids=lambda law: type(law).__name__
)
def test_they_are_the_difference_of_other_weights(law: Any) -> None:
    """d/dθ mean(w y) by weights of laws on both sides. The complying share has the opposite slope.
    Kills: a slope over another parameter, a score that is not centred."""
    rng = np.random.default_rng(4)
    x = np.array(law.ppf(rng.random(2000)))
    y = x + 0.2 * rng.normal(size=2000) > float(law.ppf(0.7))
    for parameter in SMOOTH[type(law)]:
        value, h = getattr(law, parameter), 1e-3 * getattr(law, parameter)
        sides = [replace(law, **{parameter: value + side * h}) for side in (1.0, -1.0)]
        weighted = [float(np.mean(np.exp(log_density(side, x) - log_density(law, x)) * (y - y.mean()))) for side in sides]
        found = slope(law, parameter, x, y, 0.95).estimate
        assert found is not None
        other = slope(law, parameter, x, ~y, 0.95).estimate
        assert other is not None
        assert other.value == pytest.approx(-found.value, rel=1e-9)
        assert found.value == pytest.approx((weighted[0] - weighted[1]) / (2.0 * h), rel=1e-4)


SECANTS = [
    (Uniform(0.0, 1.0), "high", (0.3 - 0.2 / 0.9) / 0.1),
    (Uniform(0.0, 1.0), "low", (0.3 / 0.9 - 0.3) / 0.1),
    (LogUniform(0.1, 1.0), "high", 0.0),
    (TruncatedNormal(0.5, 0.4, 0.0, 1.0), "low", 0.0),
    (Ball(1.0), "radius", 0.0),
]


@pytest.mark.parametrize("case", SECANTS, ids=lambda case: f"{type(case[0]).__name__}.{case[1]}")
def test_ends_have_exact_secants(case: tuple[Any, str, float]) -> None:
    """y: x > 0.7, or |x| > 0.7 in a ball: p of the law and of the law cut at a tenth, in closed form. 100 repeats: covered by
    95 % and more. Kills: a tenth of the width of a law that is not uniform, the wrong end, the share outside against all."""
    law, parameter, stated = case
    rng, n, covered = np.random.default_rng(5), 400, 0
    if isinstance(law, Ball):
        cut = 0.9 ** (1.0 / 3.0)
        truth = ((1.0 - 0.343) - (1.0 - 0.343 / cut**3)) / (1.0 - cut)
    else:
        cut = float(law.ppf(0.9 if parameter == "high" else 0.1))
        p = 1.0 - float(law.cdf(0.7))
        inside = (p - 0.1) / 0.9 if parameter == "high" else p / 0.9
        truth = (p - inside) / (getattr(law, parameter) - cut)
    if stated:
        assert truth == pytest.approx(stated)
    u = (np.arange(50_000) + 0.5) / 50_000  # the law itself, without chance
    x = np.outer(u ** (1.0 / 3.0), (1.0, 0.0, 0.0)) if isinstance(law, Ball) else np.array(law.ppf(u))
    of_law = slope(law, parameter, x, (x[:, 0] if isinstance(law, Ball) else x) > 0.7, 0.95).estimate
    assert of_law is not None
    assert of_law.value == pytest.approx(truth, rel=2e-3)
    for _ in range(100):
        if isinstance(law, Ball):
            x = rng.normal(size=(n, 3))
            x *= (rng.random(n) ** (1.0 / 3.0) / np.linalg.norm(x, axis=1))[:, None]
            y = np.linalg.norm(x, axis=1) > 0.7
        else:
            x = np.array(law.ppf(rng.random(n)))
            y = x > 0.7
        found = slope(law, parameter, x, y, 0.95).estimate
        assert found is not None
        covered += found.low <= truth <= found.high
    assert covered >= int(stats.binom.ppf(1e-4, 100, 0.95))


def test_what_has_no_slope() -> None:
    """Kills: a normal interval of a handful, a mode beyond the ends, ends of laws whose scores have no variance."""
    x = np.linspace(0.0, 1.0, 400)
    few = slope(Normal(0.0, 1.0), "mean", x, x > 0.95, 0.95)
    assert few.estimate is None
    assert few.why == "20 samples on one side, fewer than 30"
    end = slope(Triangular(0.0, 1.0, 1.0), "mode", x, x > 0.5, 0.95)
    assert (end.estimate, end.why) == (None, "mode is at an end of what it can be")
    assert parameters(Triangular(0.0, 0.5, 1.0)) == ("mode",)
    assert parameters(Beta(2.0, 2.0, 0.0, 1.0)) == ("a", "b")
    assert not ENDS.keys() & {Triangular, Beta}


def test_steps() -> None:
    """1 % of the spread for a place, of itself for a size."""
    x = np.linspace(0.0, 1.0, 400)
    assert slope(Uniform(0.0, 1.0), "low", x, x > 0.5, 0.95).step == pytest.approx(0.01 / np.sqrt(12.0), rel=1e-4)
    assert slope(Normal(50.0, 2.0), "mean", x, x > 0.5, 0.95).step == pytest.approx(0.02, rel=1e-2)
    assert slope(Exponential(4.0), "mean", x, x > 0.5, 0.95).step == pytest.approx(0.04)
