"""Laws derived from the normal law: normal, truncated normal, half normal, log normal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rvjax.campaign.distributions.interface import ABOVE_ZERO, Array, array, between, ordered, positive, wide
from rvjax.campaign.plain_values import exact
from rvjax.elementary import erf, exp, log, log1p, log_ndtr, ndtr, ndtri, ndtri_centred, ndtri_exp


@dataclass(frozen=True)
class Normal:
    """F(x) = Φ((x − mean)/sd)."""

    mean: float
    sd: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        wide("standard deviation", self.sd)

    @property
    def low(self) -> float:
        return -math.inf

    @property
    def high(self) -> float:
        return math.inf

    def ppf(self, u: ArrayLike) -> Array:
        return self.mean + self.sd * ndtri(array(u))

    def cdf(self, x: ArrayLike) -> Array:
        return ndtr((array(x) - self.mean) / self.sd)

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
        wide("standard deviation", self.sd)
        ordered(self.low, self.high)
        if max(self.low - self.mean, self.mean - self.high) > self.FARTHEST * self.sd:
            raise ValueError(f"the interval lies more than {exact(self.FARTHEST)} standard deviations from the mean")

    def _ends(self) -> tuple[float, float]:
        return (self.low - self.mean) / self.sd, (self.high - self.mean) / self.sd

    def ppf(self, u: ArrayLike) -> Array:
        a, b = self._ends()
        share, rest = log(array(u)), log1p(-array(u))
        left = _log_of_sum(rest + log_ndtr(a), share + log_ndtr(b))
        right = _log_of_sum(rest + log_ndtr(-a), share + log_ndtr(-b))
        z = np.where(left < right, array(ndtri_exp(left)), -array(ndtri_exp(right)))
        return np.clip(self.mean + self.sd * z, self.low, self.high)

    def cdf(self, x: ArrayLike) -> Array:
        a, b = self._ends()
        if a > 0.0:  # differences of upper tails, which keep their digits there
            a, b, z = -a, -b, -(array(x) - self.mean) / self.sd
        else:
            z = (array(x) - self.mean) / self.sd
        return np.clip((ndtr(z) - ndtr(a)) / (ndtr(b) - ndtr(a)), 0.0, 1.0)

    def scaled(self, factor: float) -> TruncatedNormal:
        return TruncatedNormal(self.mean * factor, self.sd * factor, self.low * factor, self.high * factor)


@dataclass(frozen=True)
class HalfNormal:
    """F(x) = erf(x/(sd√2)) for x ≥ 0: the size of a normal number with mean 0."""

    sd: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        wide("standard deviation", self.sd)

    @property
    def low(self) -> float:
        return 0.0

    @property
    def high(self) -> float:
        return math.inf

    def ppf(self, u: ArrayLike) -> Array:
        return self.sd * ndtri_centred(0.5 * array(u))

    def cdf(self, x: ArrayLike) -> Array:
        return erf(np.maximum(array(x), 0.0) / (self.sd * math.sqrt(2.0)))

    def scaled(self, factor: float) -> HalfNormal:
        return HalfNormal(self.sd * factor)


@dataclass(frozen=True)
class LogNormal:
    """F(x) = Φ(ln(x/median)/sigma_log) for x > 0.

    median: of X itself; sigma_log: standard deviation of ln X, about the relative spread where it is small. The mean of X is
    median · exp(sigma_log²/2).
    """

    median: float
    sigma_log: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        positive("median", self.median)
        between("standard deviation of the logarithm", self.sigma_log, 1e-9, 10.0)

    @property
    def low(self) -> float:
        return ABOVE_ZERO

    @property
    def high(self) -> float:
        return math.inf

    def ppf(self, u: ArrayLike) -> Array:
        return self.median * exp(self.sigma_log * ndtri(array(u)))

    def cdf(self, x: ArrayLike) -> Array:
        positive_x = np.maximum(array(x), ABOVE_ZERO)
        return np.where(array(x) > 0.0, ndtr((log(positive_x) - log(self.median)) / self.sigma_log), 0.0)

    def scaled(self, factor: float) -> LogNormal:
        return LogNormal(self.median * factor, self.sigma_log)


def _log_of_sum(x: Array, y: Array) -> Array:
    """ln(e^x + e^y)."""
    return np.maximum(x, y) + log1p(exp(-np.abs(x - y)))
