"""Densities of laws, and the supremum of the ratio of two: what samples of a law say about another one.

    ln w(x) = ln f'(x) − ln f(x),   ln W = sup over all x that f can draw

For laws with steps f is the probability of a value. The supremum is that of the laws, without any sample: in closed form on
spheres and for steps, elsewhere on points of both laws and near their ends, refined about the largest. Laws whose ratio has no
upper bound, such as a normal law with a larger standard deviation, give +∞.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import singledispatch
from typing import NamedTuple

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second

from rvjax.campaign.distributions.bounded import Beta, LogUniform, Triangular, Uniform
from rvjax.campaign.distributions.discrete import Pick, Poisson
from rvjax.campaign.distributions.interface import Array, Distribution, JointDistribution, array
from rvjax.campaign.distributions.joint import Ball, Direction, VonMisesFisher
from rvjax.campaign.distributions.normal import HalfNormal, LogNormal, Normal, TruncatedNormal
from rvjax.campaign.distributions.waiting import Exponential, Weibull

Law = Distribution | JointDistribution

HALF_LOG_2PI = 0.5 * math.log(2.0 * math.pi)

POINTS, REFINED = 801, 60
TAIL = 1e-15
"""Probability beyond the points on an infinite side."""

SPHERE = 1e-9
"""Relative difference of radii of the same sphere."""


class Ratio(NamedTuple):
    """log_sup: ln W, +∞ where the ratio has no bound. beyond: probability of the new law where the old one draws nothing; the
    ratio is that of the new law within the old one, so that its mean is 1."""

    log_sup: float
    beyond: float = 0.0


@singledispatch
def log_density(law: Law, x: Array) -> Array:
    """(n,) ln f at x: (n,), or (n, 3) for a joint law; −∞ outside. TypeError for a law without a density."""
    raise TypeError(f"{type(law).__name__} has no density")


def has_density(law: object) -> bool:
    """Whether `log_density` knows the law."""
    return log_density.dispatch(type(law)) is not log_density.dispatch(object)


def _inside(law: Distribution, x: Array, value: Array | float) -> Array:
    return np.where((x >= law.low) & (x <= law.high), value, -np.inf)


def _log(x: Array) -> Array:
    return np.log(np.maximum(x, 0.0))


def _quiet(f: Callable[..., Array]) -> Callable[..., Array]:
    """Without warnings about logarithms of 0, which are −∞."""

    def quiet(law: Law, x: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return f(law, array(x))

    return quiet


@log_density.register(Uniform)
@_quiet
def _(law: Uniform, x: Array) -> Array:
    return _inside(law, x, -math.log(law.high - law.low))


@log_density.register(LogUniform)
@_quiet
def _(law: LogUniform, x: Array) -> Array:
    return _inside(law, x, -_log(x) - math.log(math.log(law.high / law.low)))


@log_density.register(Triangular)
@_quiet
def _(law: Triangular, x: Array) -> Array:
    width, before, behind = law.high - law.low, law.mode - law.low, law.high - law.mode
    rising = _log(x - law.low) - math.log(before or 1.0)
    falling = _log(law.high - x) - math.log(behind or 1.0)
    return _inside(law, x, math.log(2.0 / width) + np.where(x < law.mode, rising, np.where(behind > 0.0, falling, rising)))


@log_density.register(Beta)
@_quiet
def _(law: Beta, x: Array) -> Array:
    width = law.high - law.low
    z, rest = (x - law.low) / width, (law.high - x) / width
    powers = scipy.special.xlogy(law.a - 1.0, np.maximum(z, 0.0)) + scipy.special.xlogy(law.b - 1.0, np.maximum(rest, 0.0))
    return _inside(law, x, powers - float(scipy.special.betaln(law.a, law.b)) - math.log(width))


@log_density.register(Normal)
@_quiet
def _(law: Normal, x: Array) -> Array:
    return -0.5 * ((x - law.mean) / law.sd) ** 2 - math.log(law.sd) - HALF_LOG_2PI


@log_density.register(TruncatedNormal)
@_quiet
def _(law: TruncatedNormal, x: Array) -> Array:
    a, b = (law.low - law.mean) / law.sd, (law.high - law.mean) / law.sd
    a, b = (a, b) if a <= 0.0 else (-b, -a)
    high, low = float(scipy.special.log_ndtr(b)), float(scipy.special.log_ndtr(a))
    whole = high + math.log1p(-math.exp(low - high))
    return _inside(law, x, -0.5 * ((x - law.mean) / law.sd) ** 2 - math.log(law.sd) - HALF_LOG_2PI - whole)


@log_density.register(HalfNormal)
@_quiet
def _(law: HalfNormal, x: Array) -> Array:
    return _inside(law, x, -0.5 * (x / law.sd) ** 2 - math.log(law.sd) - HALF_LOG_2PI + math.log(2.0))


@log_density.register(LogNormal)
@_quiet
def _(law: LogNormal, x: Array) -> Array:
    z = (_log(x) - math.log(law.median)) / law.sigma_log
    return np.where(x > 0.0, -0.5 * z**2 - _log(x) - math.log(law.sigma_log) - HALF_LOG_2PI, -np.inf)


@log_density.register(Exponential)
@_quiet
def _(law: Exponential, x: Array) -> Array:
    return _inside(law, x, -x / law.mean - math.log(law.mean))


@log_density.register(Weibull)
@_quiet
def _(law: Weibull, x: Array) -> Array:
    z = np.maximum(x, 0.0) / law.scale
    return _inside(law, x, scipy.special.xlogy(law.shape - 1.0, z) - z**law.shape + math.log(law.shape / law.scale))


@log_density.register(Pick)
@_quiet
def _(law: Pick, x: Array) -> Array:
    found = np.full(x.shape, -np.inf)
    for value, weight in zip(law.values, law.weights, strict=True):
        found = np.where(x == value, np.logaddexp(found, math.log(weight)), found)
    return found


@log_density.register(Poisson)
@_quiet
def _(law: Poisson, x: Array) -> Array:
    k = np.round(x / law.step)
    value = k * math.log(law.mean) - law.mean - scipy.special.gammaln(np.maximum(k, 0.0) + 1.0)
    return np.where((k >= 0) & (np.abs(k * law.step - x) <= 1e-9 * np.maximum(np.abs(x), law.step)), value, -np.inf)


@log_density.register(Ball)
@_quiet
def _(law: Ball, x: Array) -> Array:
    return np.where(
        np.linalg.norm(x, axis=1) <= law.radius * (1.0 + SPHERE), -math.log(4.0 / 3.0 * math.pi * law.radius**3), -np.inf
    )


@log_density.register(Direction)
@_quiet
def _(law: Direction, x: Array) -> Array:
    return np.full(len(x), -math.log(4.0 * math.pi))


@log_density.register(VonMisesFisher)
@_quiet
def _(law: VonMisesFisher, x: Array) -> Array:
    along = x @ array(law.mean) / law.radius
    return law.kappa * (along - 1.0) + math.log(law.kappa / (2.0 * math.pi)) - math.log(-math.expm1(-2.0 * law.kappa))


def ratio(old: Law, new: Law) -> Ratio:
    """The supremum of f'/f, and the part of f' beyond f. TypeError for laws that have no ratio: those without a density, with
    steps and without, on different spheres."""
    for law in (old, new):
        log_density.dispatch(type(law))(law, np.zeros((0, 3)))
    if isinstance(old, (Pick, Poisson)) or isinstance(new, (Pick, Poisson)):
        return _of_steps(old, new)
    if isinstance(old, Ball) and isinstance(new, Ball):
        within = min(1.0, (old.radius / new.radius) ** 3)
        return Ratio(3.0 * math.log(old.radius / min(new.radius, old.radius)), 1.0 - within)
    if isinstance(old, (Direction, VonMisesFisher)) and isinstance(new, (Direction, VonMisesFisher)):
        return _on_sphere(old, new)
    scalar = [law for law in (old, new) if not isinstance(law, (Ball, Direction, VonMisesFisher))]
    if len(scalar) < 2:
        raise TypeError("a joint law and another one have no ratio")
    return _of_scalars(*scalar)  # pyright: ignore[reportArgumentType]


def _on_sphere(old: Direction | VonMisesFisher, new: Direction | VonMisesFisher) -> Ratio:
    """exp(κ' m'·x − κ m·x) is largest along κ' m' − κ m."""
    if abs(old.radius - new.radius) > SPHERE * old.radius:
        raise TypeError("directions of different length have no ratio")
    before, after = (array(law.mean) * law.kappa if isinstance(law, VonMisesFisher) else np.zeros(3) for law in (old, new))
    change = after - before
    size = float(np.linalg.norm(change))
    at = (change / size if size > 0.0 else array((1.0, 0.0, 0.0)))[None] * old.radius
    return Ratio(float((log_density(new, at) - log_density(old, at))[0]))


def _of_steps(old: Law, new: Law) -> Ratio:
    """Over the values that both can take; of two Poisson laws, whose ratio falls where the new mean is not larger, at 0."""
    if type(old) is not type(new):
        raise TypeError("a law with steps and another one have no ratio")
    if isinstance(old, Poisson) and isinstance(new, Poisson):
        if old.step != new.step:
            raise TypeError("counts in different units have no ratio")
        return Ratio(old.mean - new.mean if new.mean <= old.mean else math.inf)
    assert isinstance(old, Pick)
    assert isinstance(new, Pick)
    common = array(sorted(set(old.values) & set(new.values)))
    if not len(common):
        return Ratio(math.inf, 1.0)
    logs = log_density(new, common)
    within = min(1.0, float(np.exp(logs).sum()))
    return Ratio(float(np.max(logs - log_density(old, common))) - math.log(within), max(0.0, 1.0 - within))


def _of_scalars(old: Distribution, new: Distribution) -> Ratio:
    low, high = max(old.low, new.low), min(old.high, new.high)
    if low >= high:
        return Ratio(math.inf, 1.0)
    outside = float(new.cdf(low)) * (new.low < old.low) + (1.0 - float(new.cdf(high))) * (new.high > old.high)
    beyond = min(1.0, max(0.0, outside))
    if beyond >= 1.0 - TAIL or (math.isinf(high) and _tail(old, new, 1.0)) or (math.isinf(low) and _tail(old, new, -1.0)):
        return Ratio(math.inf, beyond)
    shares = np.concatenate(
        [np.linspace(0.0, 1.0, POINTS)[1:-1], np.geomspace(TAIL, 0.5, 400), 1.0 - np.geomspace(TAIL, 0.5, 400)]
    )
    x = np.concatenate(
        [old.ppf(shares), new.ppf(shares), _near_ends(low, high), array(getattr(new, "mode", new.ppf(0.5))).ravel()]
    )
    x = np.unique(x[(x >= low) & (x <= high) & np.isfinite(x)])

    def h(at: Array) -> Array:
        with np.errstate(invalid="ignore"):
            found = log_density(new, at) - log_density(old, at)
        return np.where(np.isnan(found), -np.inf, found)

    values = h(x)
    best = float(values.max())
    if math.isinf(best) or _rises_to_an_end(low, high, h):
        return Ratio(math.inf, beyond)
    for place in np.argsort(values)[-5:]:
        left, right = float(x[max(place - 1, 0)]), float(x[min(place + 1, len(x) - 1)])
        for _ in range(REFINED):
            inner = np.linspace(left, right, 9)
            top = int(np.argmax(h(inner)))
            best = max(best, float(h(inner)[top]))
            left, right = float(inner[max(top - 1, 0)]), float(inner[min(top + 1, 8)])
            if right - left <= 1e-12 * max(abs(left), abs(right), 1e-300):
                break
    return Ratio(best - math.log1p(-beyond), beyond)


def _near_ends(low: float, high: float) -> Array:
    """Finite ends, and points that come nearer and nearer to them."""
    scale = high - low if math.isfinite(high - low) else max(abs(low) if math.isfinite(low) else abs(high), 1.0)
    steps = scale * np.geomspace(1e-14, 0.5, 60)
    points = [np.concatenate([[low], low + steps])] if math.isfinite(low) else []
    points += [np.concatenate([[high], high - steps])] if math.isfinite(high) else []
    return np.concatenate([*points, array([])])


def _rises_to_an_end(low: float, high: float, h: Callable[[Array], Array]) -> bool:
    """Whether the ratio grows without bound towards a finite end, as that of two powers does: as much for each factor of 100."""
    for end, inward in ((low, 1.0), (high, -1.0)):
        if math.isfinite(end):
            scale = max(abs(end), 1.0) if not math.isfinite(high - low) else high - low
            steps = h(end + inward * scale * np.array([1e-6, 1e-8, 1e-10]))
            if np.all(np.diff(steps) > 1e-3) and steps[2] - steps[1] > 0.5 * (steps[1] - steps[0]):
                return True
    return False


def _tail(old: Distribution, new: Distribution, side: float) -> bool:
    """Whether f'/f grows without bound far out: judged where x doubles again and again, by the densities themselves."""
    width = float(np.ptp(np.concatenate([old.ppf([0.05, 0.95]), new.ppf([0.05, 0.95])])))
    centre = float(old.ppf(0.5))
    far = centre + side * width * np.geomspace(8.0, 8.0 * 2.0**20, 21)
    with np.errstate(invalid="ignore"):
        found = log_density(new, far) - log_density(old, far)
    known = found[np.isfinite(found)]
    return len(known) > 1 and bool(np.all(np.diff(known) > 0.0)) and float(known[-1] - known[-2]) > 1e-9
