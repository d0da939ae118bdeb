"""Laws on an interval: uniform, uniform in the logarithm, triangular, beta."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import ArrayLike

from rvjax.campaign.distributions.interface import Array, array, between, ordered, positive
from rvjax.elementary import exp, log
from rvjax.elementary.incomplete_beta import beta_quantile


@dataclass(frozen=True)
class Uniform:
    """F(x) = (x − a)/(b − a) on [a, b]."""

    low: float
    high: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        ordered(self.low, self.high)

    def ppf(self, u: ArrayLike) -> Array:
        share = array(u)
        return np.clip(self.low * (1.0 - share) + self.high * share, self.low, self.high)

    def cdf(self, x: ArrayLike) -> Array:
        return np.clip((array(x) - self.low) / (self.high - self.low), 0.0, 1.0)

    def scaled(self, factor: float) -> Uniform:
        return Uniform(self.low * factor, self.high * factor)


@dataclass(frozen=True)
class LogUniform:
    """F(x) = ln(x/a)/ln(b/a) on [a, b], a > 0."""

    low: float
    high: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        positive("low end", self.low)
        ordered(self.low, self.high)

    @property
    def _logs(self) -> tuple[float, float]:
        return float(log(self.low)), float(log(self.high))

    def ppf(self, u: ArrayLike) -> Array:
        share = array(u)
        return np.clip(exp(self._logs[0] * (1.0 - share) + self._logs[1] * share), self.low, self.high)

    def cdf(self, x: ArrayLike) -> Array:
        inside = np.clip(array(x), self.low, self.high)
        low, high = self._logs
        return (log(inside) - low) / (high - low)

    def scaled(self, factor: float) -> LogUniform:
        return LogUniform(self.low * factor, self.high * factor)


@dataclass(frozen=True)
class Triangular:
    """F(x) = (x − a)²/((b − a)(m − a)) on [a, m], 1 − (b − x)²/((b − a)(b − m)) on [m, b], with the mode m anywhere on [a, b].

    Inverted from the nearer end, so both tails keep their digits.
    """

    low: float
    mode: float
    high: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        ordered(self.low, self.high)
        if not self.low <= self.mode <= self.high:
            raise ValueError("the mode must be between the ends")

    def ppf(self, u: ArrayLike) -> Array:
        share, width = array(u), self.high - self.low
        rising = self.low + np.sqrt(share * width * (self.mode - self.low))
        falling = self.high - np.sqrt((1.0 - share) * width * (self.high - self.mode))
        return np.clip(np.where(share * width < self.mode - self.low, rising, falling), self.low, self.high)

    def cdf(self, x: ArrayLike) -> Array:
        inside, width = np.clip(array(x), self.low, self.high), self.high - self.low
        before, behind = (self.mode - self.low) or 1.0, (self.high - self.mode) or 1.0
        rising = (inside - self.low) / width * ((inside - self.low) / before)
        falling = 1.0 - (self.high - inside) / width * ((self.high - inside) / behind)
        return np.where(inside < self.mode, rising, falling)

    def scaled(self, factor: float) -> Triangular:
        return Triangular(self.low * factor, self.mode * factor, self.high * factor)


@dataclass(frozen=True)
class Beta:
    """F(x) = I_z(a, b), z = (x − low)/(high − low): the regularised incomplete beta function on [low, high].

    Its density goes with z^(a−1) (1 − z)^(b−1). Inverted from the nearer end, so both tails keep their digits.
    """

    a: float
    b: float
    low: float
    high: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        between("first shape", self.a, 0.1, 1e6)
        between("second shape", self.b, 0.1, 1e6)
        ordered(self.low, self.high)

    def ppf(self, u: ArrayLike) -> Array:
        share, width = array(u), self.high - self.low
        z, rest = beta_quantile(self.a, self.b, share)
        return np.clip(np.where(z < 0.5, self.low + width * z, self.high - width * rest), self.low, self.high)

    def cdf(self, x: ArrayLike) -> Array:
        return array(scipy.special.betainc(self.a, self.b, np.clip((array(x) - self.low) / (self.high - self.low), 0.0, 1.0)))

    def scaled(self, factor: float) -> Beta:
        return Beta(self.a, self.b, self.low * factor, self.high * factor)
