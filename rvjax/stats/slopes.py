"""How a probability changes with the parameters of a law, from independent samples of that law.

    p(θ) = P(y),   dp/dθ = E[y s] = E[(y − p) s],   s = ∂ ln f_θ(x)/∂θ,   E s = 0

    parameter that leaves the support as it is    mean((y − ȳ) s), normal interval, nominal
    end of a support that cuts the law            q (P(y | outside) − P(y | inside))/Δ, exact bounds

The first is the score-function estimator (R. Y. Rubinstein & A. Shapiro, Discrete Event Systems, 1993, ch. 2). Where an end moves
there is no score, and the derivative is the failure probability at the end, a density that no number of samples gives without an
assumption. So that slope is the secant from the present end to one that cuts off the outermost q = 1/10 of the law, Δ nearer:
what is inside is the narrower law exactly. The ends of other laws (triangular, beta) have scores of infinite variance: no slope.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import ArrayLike, NDArray

from rvjax.campaign.distributions.bounded import Beta, LogUniform, Triangular, Uniform
from rvjax.campaign.distributions.discrete import Poisson
from rvjax.campaign.distributions.joint import Ball, VonMisesFisher
from rvjax.campaign.distributions.normal import HalfNormal, LogNormal, Normal, TruncatedNormal
from rvjax.campaign.distributions.waiting import Exponential, Weibull
from rvjax.stats.binomial import Estimate, clopper_pearson
from rvjax.stats.densities import Law, log_density

Values = NDArray[np.float64]

OUTER = 0.1
"""Probability that the nearer end cuts off."""

FEWEST_OF_EACH = 30
"""Samples with the property, and without: with fewer, a normal interval means little."""

STEP = 1e-4
"""Relative step of the numerical derivative of ln f, whose error is its square."""

SMOOTH: dict[type[Any], tuple[str, ...]] = {
    Normal: ("mean", "sd"),
    TruncatedNormal: ("mean", "sd"),
    HalfNormal: ("sd",),
    LogNormal: ("median", "sigma_log"),
    Triangular: ("mode",),
    Beta: ("a", "b"),
    Exponential: ("mean",),
    Weibull: ("scale", "shape"),
    Poisson: ("mean",),
    VonMisesFisher: ("kappa",),
}
"""Parameters that leave the support as it is."""

ENDS: dict[type[Any], tuple[str, ...]] = {
    Uniform: ("low", "high"),
    LogUniform: ("low", "high"),
    TruncatedNormal: ("low", "high"),
    Ball: ("radius",),
}
"""Ends that cut the law: a nearer one leaves the law inside as it was."""

RELATIVE = (LogUniform, LogNormal, Exponential, Poisson)
"""Laws on a logarithmic scale, or of a single parameter: all of these are sizes."""

PLACES = {"mean", "median", "mode", "low", "high", "radius"}
"""Parameters in the unit of the draw, which are small or large beside its spread."""


class Slope(NamedTuple):
    """Of the probability over a parameter. parameter: its name; value: that it has; step: 1 % of the spread of the draw for a
    place, 1 % of itself for a size; estimate: dp/dθ; None where there is none, for the reason `why`."""

    parameter: str
    value: float
    step: float
    estimate: Estimate | None
    why: str = ""


def parameters(law: Law) -> tuple[str, ...]:
    """The parameters that have slopes."""
    return (*SMOOTH.get(type(law), ()), *ENDS.get(type(law), ()))


def slope(law: Law, parameter: str, x: ArrayLike, y: ArrayLike, confidence: float) -> Slope:
    """dp/dθ at the present law. x: (n,) samples of it, or (n, 3) of a joint one; y: (n,) bool, whether each has the property."""
    values, marks = np.asarray(x, dtype=float), np.asarray(y, dtype=bool).ravel()
    value = float(getattr(law, parameter))
    step = 0.01 * (spread(law) if parameter in PLACES and not isinstance(law, RELATIVE) else abs(value))
    if parameter in ENDS.get(type(law), ()):
        outside, distance = _outermost(law, parameter, values)
        return Slope(parameter, value, step, _secant(marks, outside, distance, confidence))
    few = min(int(np.count_nonzero(marks)), int(np.count_nonzero(~marks)))
    if few < FEWEST_OF_EACH:
        return Slope(parameter, value, step, None, f"{few} samples on one side, fewer than {FEWEST_OF_EACH}")
    try:
        return Slope(parameter, value, step, _by_score(marks, score(law, parameter, values), confidence))
    except ValueError:
        return Slope(parameter, value, step, None, f"{parameter} is at an end of what it can be")


def spread(law: Law) -> float:
    """Standard deviation of the law, by its quantiles; of a ball that of a component."""
    if isinstance(law, Ball):
        return law.radius / math.sqrt(5.0)
    quantiles: Any = getattr(law, "ppf", None)
    if quantiles is None:
        return abs(float(getattr(law, "radius", 1.0)))
    return float(np.std(quantiles((np.arange(4000) + 0.5) / 4000)))


def score(law: Law, parameter: str, x: ArrayLike) -> Values:
    """(n,) ∂ ln f/∂θ at x, by a central difference. ValueError where the law does not exist on both sides."""
    value = float(getattr(law, parameter))
    h = STEP * (abs(value) if parameter not in PLACES or value == 0.0 else spread(law))
    h = h or STEP * spread(law)
    above, below = (replace(law, **{parameter: value + side * h}) for side in (1.0, -1.0))  # pyright: ignore
    return (log_density(above, np.asarray(x, dtype=float)) - log_density(below, np.asarray(x, dtype=float))) / (2.0 * h)  # pyright: ignore


def _by_score(y: NDArray[np.bool_], s: Values, confidence: float) -> Estimate:
    terms = (y - float(y.mean())) * s
    half = float(scipy.special.ndtri((1.0 + confidence) / 2.0)) * float(np.std(terms)) / math.sqrt(len(y))
    value = float(terms.mean())
    return Estimate(value, value - half, value + half, len(y), confidence, "score function, normal, nominal")


def _outermost(law: Any, parameter: str, x: Values) -> tuple[NDArray[np.bool_], float]:
    """(n,) which samples the nearer end cuts off; how far it moves, below 0 where the end falls."""
    if isinstance(law, Ball):
        cut = law.radius * (1.0 - OUTER) ** (1.0 / 3.0)
        return np.linalg.norm(x, axis=1) > cut, law.radius - cut
    if parameter == "high":
        cut = float(law.ppf(1.0 - OUTER))
        return x > cut, law.high - cut
    cut = float(law.ppf(OUTER))
    return x < cut, law.low - cut


def _secant(y: NDArray[np.bool_], outside: NDArray[np.bool_], distance: float, confidence: float) -> Estimate:
    """q (P(y | outside) − P(y | inside))/Δ; each share with half of the risk."""
    each = 1.0 - (1.0 - confidence) / 2.0
    out, inner = (
        clopper_pearson(int(np.count_nonzero(y & part)), int(np.count_nonzero(part)), each) for part in (outside, ~outside)
    )
    factor = OUTER / distance
    ends = sorted((factor * (out.low - inner.high), factor * (out.high - inner.low)))
    method = f"secant to an end that cuts off {100 * OUTER:g} %, Clopper-Pearson"
    return Estimate(factor * (out.value - inner.value), ends[0], ends[1], len(y), confidence, method)
