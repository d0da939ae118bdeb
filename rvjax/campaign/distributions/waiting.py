"""Laws of times until something happens: exponential, Weibull."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rvjax.campaign.distributions.interface import Array, array, between, wide
from rvjax.elementary import expm1, log1p, power


@dataclass(frozen=True)
class Exponential:
    """F(x) = 1 − exp(−x/mean) for x ≥ 0: the time to an event whose hazard rate is constant, 1/mean."""

    mean: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        wide("mean", self.mean)

    @property
    def low(self) -> float:
        return 0.0

    @property
    def high(self) -> float:
        return math.inf

    def ppf(self, u: ArrayLike) -> Array:
        return -self.mean * log1p(-array(u))

    def cdf(self, x: ArrayLike) -> Array:
        return -expm1(-np.maximum(array(x), 0.0) / self.mean)

    def scaled(self, factor: float) -> Exponential:
        return Exponential(self.mean * factor)


@dataclass(frozen=True)
class Weibull:
    """F(x) = 1 − exp(−(x/scale)^shape) for x ≥ 0: hazard rate shape/scale (x/scale)^(shape−1), falling, constant or rising.

    shape < 1: early failures; 1: the exponential law with mean scale; > 1: wear.
    """

    scale: float
    shape: float
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        wide("scale", self.scale)
        between("shape", self.shape, 0.1, 1e6)

    @property
    def low(self) -> float:
        return 0.0

    @property
    def high(self) -> float:
        return math.inf

    def ppf(self, u: ArrayLike) -> Array:
        return self.scale * power(-log1p(-array(u)), 1.0 / self.shape)

    def cdf(self, x: ArrayLike) -> Array:
        return -expm1(-power(np.maximum(array(x), 0.0) / self.scale, self.shape))

    def scaled(self, factor: float) -> Weibull:
        return Weibull(self.scale * factor, self.shape)
