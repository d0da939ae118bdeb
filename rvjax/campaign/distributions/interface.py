"""What a distribution is, and what all of them need.

Every class carries its parameters in one unit, refuses parameters that make no distribution (ValueError whose text is
for the user), and knows its support, so that ranges are checked for every possible draw and not for some.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvjax.campaign.plain_values import exact

Array = NDArray[np.float64]

ABOVE_ZERO = math.ulp(0.0)
"""Low end of a law whose draws are above 0 and come arbitrarily near."""


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


def array(values: ArrayLike) -> Array:
    """The values in double precision."""
    return np.asarray(values, dtype=np.float64)


def ordered(*values: float) -> None:
    """ValueError unless the values rise."""
    if any(a >= b for a, b in pairwise(values)):
        raise ValueError("the low end must not be above the high end")


def positive(name: str, value: float) -> None:
    """ValueError unless a parameter is above 0."""
    if value <= 0.0:
        raise ValueError(f"the {name} must be above 0")


def wide(name: str, value: float) -> None:
    """ValueError unless a width is above 0. The notation makes a number of width 0, so the text includes 0."""
    if value <= 0.0:
        raise ValueError(f"the {name} must be at least 0")


def between(name: str, value: float, low: float, high: float) -> None:
    """ValueError unless a parameter is in a range in which draws keep their digits."""
    if not low <= value <= high:
        raise ValueError(f"the {name} must be {exact(low)} to {exact(high)}")
