"""Laws with steps: a fixed number, a choice of numbers, a count of events."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from functools import cached_property
from itertools import accumulate
from typing import ClassVar

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import ArrayLike

from rvjax.campaign.distributions.interface import Array, array, between, positive


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
        return np.full_like(array(u), self.value)

    def cdf(self, x: ArrayLike) -> Array:
        return (array(x) >= self.value).astype(np.float64)

    def scaled(self, factor: float) -> Fixed:
        return Fixed(self.value * factor)


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
        return array(self.values)[np.searchsorted(self._steps(), array(u), side="left")]

    def cdf(self, x: ArrayLike) -> Array:
        return np.concatenate(([0.0], self._steps()))[np.searchsorted(self.values, array(x), side="right")]

    def scaled(self, factor: float) -> Pick:
        return Pick(tuple(value * factor for value in self.values), self.weights)


@dataclass(frozen=True)
class Poisson:
    """P(X = step · k) = exp(−mean) mean^k/k!, k = 0, 1, 2, …: the count of events that come at a constant rate.

    step: 1, or the unit of the key in SI. Inverted by search in F up to its middle, and in 1 − F above it, so the tails keep
    their digits.
    """

    mean: float
    step: float = 1.0
    uniforms: ClassVar[int] = 1

    def __post_init__(self) -> None:
        between("mean", self.mean, 1e-9, 1e5)
        positive("step", self.step)

    @property
    def low(self) -> float:
        return 0.0

    @property
    def high(self) -> float:
        return math.inf

    @cached_property
    def _counts(self) -> tuple[Array, Array, Array]:
        """Counts, all that double precision can draw, their F, and their 1 − F.

        P(k)/P(k − 1) = mean/k from the most likely count on, divided by the sum, in decimal arithmetic of 30 digits.
        """
        reach = 12.0 * math.sqrt(self.mean) + 60.0
        first, last = max(0, math.floor(self.mean - reach)), math.ceil(self.mean + reach)
        with localcontext(Context(prec=30)):
            mean, mode = Decimal(self.mean), math.floor(self.mean)
            falling = list(accumulate(range(mode + 1, last), lambda share, k: share * mean / k, initial=Decimal(1)))
            rising = list(accumulate(range(mode, first, -1), lambda share, k: share * k / mean, initial=Decimal(1)))
            shares = [*rising[:0:-1], *falling]
            total = sum(shares, Decimal(0))
            below = [float(share / total) for share in accumulate(shares)]
            above = [float(share / total) for share in accumulate(reversed(shares[1:]), initial=Decimal(0))]
        return np.arange(first, last, dtype=np.float64), array(below), array(above[::-1])

    def ppf(self, u: ArrayLike) -> Array:
        share = array(u)
        k, below, above = self._counts
        left = np.searchsorted(below, share, side="left")
        right = len(above) - np.searchsorted(above[::-1], 1.0 - share, side="right")
        return self.step * k[np.minimum(np.where(share < 0.5, left, right), len(k) - 1)]

    def cdf(self, x: ArrayLike) -> Array:
        k = np.floor(array(x) / self.step * (1.0 + 1e-15))
        return np.where(k < 0.0, 0.0, scipy.special.pdtr(np.maximum(k, 0.0), self.mean))

    def scaled(self, factor: float) -> Poisson:
        return Poisson(self.mean, self.step * factor)
