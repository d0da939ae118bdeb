"""Distributions of drawn numbers, each through its inverse: x = F⁻¹(u) with u uniform in (0, 1).

Every class carries its parameters in one unit, refuses parameters that make no distribution (ValueError whose text is
for the user), and knows its support, so that ranges are checked for every possible draw and not for some.
Inverses follow L. Devroye, "Non-Uniform Random Variate Generation", Springer, 1986, chapters II and V.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import erf, erfinv, log_ndtr, ndtr, ndtri, ndtri_exp  # pyright: ignore[reportMissingTypeStubs]

Array = NDArray[np.float64]


class Distribution(Protocol):
    """A scalar law with support [low, high]; one draw consumes `uniforms` uniform numbers."""

    uniforms: ClassVar[int]

    @property
    def low(self) -> float: ...

    @property
    def high(self) -> float: ...

    def ppf(self, u: ArrayLike) -> Array:
        """F⁻¹(u), element by element."""
        ...

    def cdf(self, x: ArrayLike) -> Array:
        """F(x) = P(X ≤ x), element by element."""
        ...

    def scaled(self, factor: float) -> Distribution:
        """The law of factor · X, factor > 0."""
        ...


def _array(values: ArrayLike) -> Array:
    return np.asarray(values, dtype=np.float64)


def _ordered(*values: float) -> None:
    if any(a >= b for a, b in pairwise(values)):
        raise ValueError("the low end must be below the high end")


def _positive(name: str, value: float) -> None:
    if value <= 0.0:
        raise ValueError(f"the {name} must be above 0")


@dataclass(frozen=True)
class Fixed:
    """X = value."""

    value: float
    uniforms: ClassVar[int] = 0

    @property
    def low(self) -> float:
        return self.value

    @property
    def high(self) -> float:
        return self.value

    def ppf(self, u: ArrayLike) -> Array:
        return np.full_like(_array(u), self.value)

    def cdf(self, x: ArrayLike) -> Array:
        return (_array(x) >= self.value).astype(np.float64)

    def scaled(self, factor: float) -> Fixed:
        return Fixed(self.value * factor)


@dataclass(frozen=True)
class Uniform:
    """F(x) = (x − a)/(b − a) on [a, b]."""

    low: float
    high: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        _ordered(self.low, self.high)

    def ppf(self, u: ArrayLike) -> Array:
        share = _array(u)
        return np.clip(self.low * (1.0 - share) + self.high * share, self.low, self.high)

    def cdf(self, x: ArrayLike) -> Array:
        return np.clip((_array(x) - self.low) / (self.high - self.low), 0.0, 1.0)

    def scaled(self, factor: float) -> Uniform:
        return Uniform(self.low * factor, self.high * factor)


@dataclass(frozen=True)
class Normal:
    """F(x) = Φ((x − mean)/sd)."""

    mean: float
    sd: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        _positive("standard deviation", self.sd)

    @property
    def low(self) -> float:
        return -math.inf

    @property
    def high(self) -> float:
        return math.inf

    def ppf(self, u: ArrayLike) -> Array:
        return self.mean + self.sd * ndtri(_array(u))

    def cdf(self, x: ArrayLike) -> Array:
        return ndtr((_array(x) - self.mean) / self.sd)

    def scaled(self, factor: float) -> Normal:
        return Normal(self.mean * factor, self.sd * factor)


@dataclass(frozen=True)
class TruncatedNormal:
    """F(x) = (Φ(z) − Φ(a))/(Φ(b) − Φ(a)), z = (x − mean)/sd, a and b the ends in the same scale.

    Inverted in logarithms from the nearer tail, ln Φ(z) = ln[(1 − u)Φ(a) + uΦ(b)] or
    ln Φ(−z) = ln[(1 − u)Φ(−a) + uΦ(−b)], so an interval in a far tail loses no digits.
    """

    mean: float
    sd: float
    low: float
    high: float
    uniforms: ClassVar[int] = 1

    FARTHEST: ClassVar[float] = 30.0
    """Standard deviations from the mean to the nearer end of an interval beside it; beyond, nothing is left."""

    def __post_init__(self) -> None:
        _positive("standard deviation", self.sd)
        _ordered(self.low, self.high)
        if max(self.low - self.mean, self.mean - self.high) > self.FARTHEST * self.sd:
            raise ValueError(f"the interval lies more than {self.FARTHEST:g} standard deviations from the mean")

    def _ends(self) -> tuple[float, float]:
        return (self.low - self.mean) / self.sd, (self.high - self.mean) / self.sd

    def ppf(self, u: ArrayLike) -> Array:
        a, b = self._ends()
        share, rest = np.log(_array(u)), np.log1p(-_array(u))
        left = np.logaddexp(rest + log_ndtr(a), share + log_ndtr(b))
        right = np.logaddexp(rest + log_ndtr(-a), share + log_ndtr(-b))
        z = np.where(left < right, _array(ndtri_exp(left)), -_array(ndtri_exp(right)))
        return np.clip(self.mean + self.sd * z, self.low, self.high)

    def cdf(self, x: ArrayLike) -> Array:
        a, b = self._ends()
        if a > 0.0:  # differences of upper tails, which keep their digits there
            a, b, z = -a, -b, -(_array(x) - self.mean) / self.sd
        else:
            z = (_array(x) - self.mean) / self.sd
        return np.clip((ndtr(z) - ndtr(a)) / (ndtr(b) - ndtr(a)), 0.0, 1.0)

    def scaled(self, factor: float) -> TruncatedNormal:
        return TruncatedNormal(self.mean * factor, self.sd * factor, self.low * factor, self.high * factor)


@dataclass(frozen=True)
class LogUniform:
    """F(x) = ln(x/a)/ln(b/a) on [a, b], a > 0."""

    low: float
    high: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        _positive("low end", self.low)
        _ordered(self.low, self.high)

    def ppf(self, u: ArrayLike) -> Array:
        share = _array(u)
        return np.clip(np.exp(math.log(self.low) * (1.0 - share) + math.log(self.high) * share), self.low, self.high)

    def cdf(self, x: ArrayLike) -> Array:
        inside = np.clip(_array(x), self.low, self.high)
        return (np.log(inside) - math.log(self.low)) / (math.log(self.high) - math.log(self.low))

    def scaled(self, factor: float) -> LogUniform:
        return LogUniform(self.low * factor, self.high * factor)


@dataclass(frozen=True)
class HalfNormal:
    """F(x) = erf(x/(sd√2)) for x ≥ 0: the size of a normal number with mean 0."""

    sd: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        _positive("standard deviation", self.sd)

    @property
    def low(self) -> float:
        return 0.0

    @property
    def high(self) -> float:
        return math.inf

    def ppf(self, u: ArrayLike) -> Array:
        return self.sd * math.sqrt(2.0) * erfinv(_array(u))

    def cdf(self, x: ArrayLike) -> Array:
        return erf(np.maximum(_array(x), 0.0) / (self.sd * math.sqrt(2.0)))

    def scaled(self, factor: float) -> HalfNormal:
        return HalfNormal(self.sd * factor)


@dataclass(frozen=True)
class Pick:
    """P(X = values[i]) = weights[i]; a campaign calls it `choice`. Values in rising order, weights add up to 1."""

    values: tuple[float, ...]
    weights: tuple[float, ...]
    uniforms: ClassVar[int] = 1

    @classmethod
    def of(cls, values: Sequence[float], weights: Sequence[float] | None = None) -> Pick:
        """Equal weights unless they are given; given ones may have any sum above 0."""
        shares = [1.0] * len(values) if weights is None else weights
        if not values:
            raise ValueError("there is nothing to choose from")
        if len(shares) != len(values):
            raise ValueError(f"{len(values)} values but {len(shares)} weights")
        if min(shares) <= 0.0:
            raise ValueError("every weight must be above 0")
        pairs = sorted(zip(values, shares, strict=True))
        total = math.fsum(shares)
        return cls(tuple(value for value, _ in pairs), tuple(weight / total for _, weight in pairs))

    @property
    def low(self) -> float:
        return self.values[0]

    @property
    def high(self) -> float:
        return self.values[-1]

    def _steps(self) -> Array:
        steps = np.cumsum(self.weights)
        steps[-1] = 1.0
        return steps

    def ppf(self, u: ArrayLike) -> Array:
        return _array(self.values)[np.searchsorted(self._steps(), _array(u), side="left")]

    def cdf(self, x: ArrayLike) -> Array:
        return np.concatenate(([0.0], self._steps()))[np.searchsorted(self.values, _array(x), side="right")]

    def scaled(self, factor: float) -> Pick:
        return Pick(tuple(value * factor for value in self.values), self.weights)


class JointDistribution(Protocol):
    """A law of three numbers that are not independent; one draw consumes `uniforms` uniform numbers."""

    uniforms: ClassVar[int]

    @property
    def radius(self) -> float:
        """Largest norm: the support lies in the ball of this radius."""
        ...

    def ppf(self, u: ArrayLike) -> Array:
        """(n, uniforms) uniform numbers → (n, 3) points."""
        ...

    def scaled(self, factor: float) -> JointDistribution:
        """The law of factor · X, factor > 0."""
        ...


def _on_sphere(u: Array) -> Array:
    """z = 2u₁ − 1, azimuth 2πu₂ (Archimedes: the height of a uniform point on a sphere is uniform)."""
    z, azimuth = 2.0 * u[:, 0] - 1.0, 2.0 * math.pi * u[:, 1]
    across = 2.0 * np.sqrt(u[:, 0] * (1.0 - u[:, 0]))
    return np.stack((across * np.cos(azimuth), across * np.sin(azimuth), z), axis=1)


@dataclass(frozen=True)
class Direction:
    """Uniform on the sphere |X| = radius."""

    radius: float
    uniforms: ClassVar[int] = 2

    def __post_init__(self) -> None:
        _positive("radius", self.radius)

    def ppf(self, u: ArrayLike) -> Array:
        return self.radius * _on_sphere(_array(u))

    def scaled(self, factor: float) -> Direction:
        return Direction(self.radius * factor)


@dataclass(frozen=True)
class Ball:
    """Uniform in the ball |X| ≤ radius: |X| = radius · ∛u₃ along a uniform direction."""

    radius: float
    uniforms: ClassVar[int] = 3

    def __post_init__(self) -> None:
        _positive("radius", self.radius)

    def ppf(self, u: ArrayLike) -> Array:
        share = _array(u)
        return self.radius * np.cbrt(share[:, 2:3]) * _on_sphere(share[:, :2])

    def scaled(self, factor: float) -> Ball:
        return Ball(self.radius * factor)
