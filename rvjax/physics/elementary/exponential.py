"""Exponential functions by arithmetic only.

    k = the integer nearest to x/ln 2
    r = x − k ln 2,  |r| ≤ ln 2/2                 ln 2 is a sum of two parts, so k times the first has no rounding error
    e^x = 2^k (1 + r + r² P(r))
    e^x − 1 = (2^k − 1) + 2^k (r + r² P(r))

P: Chebyshev fit over |r| ≤ ln 2/2, error of e^r 1e-17 (float64) or 8e-9 (float32). 2^k is a product of two numbers, so that
results below the smallest normal number are rounded only once. W. Cody, W. Waite, "Software manual for the elementary functions",
1980, ch. 6; coefficients: tests/physics/test_elementary_fits.py.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import jax.numpy as jnp

from rvjax.physics.elementary.formats import FLOAT32, elementary, format_of, polynomial, power_of_two, scaled
from rvjax.physics.vectors import Scalar


class _Tables(NamedTuple):
    """parts: of ln 2. lowest, highest: e^x is 0 or ∞ beyond. fit: coefficients of P, from the lowest."""

    parts: tuple[float, float]
    lowest: float
    highest: float
    fit: tuple[float, ...]


_FLOAT64 = _Tables(
    parts=(0.693147180559663, 2.8235290563031577e-13),
    lowest=-746.0,
    highest=710.0,
    fit=(
        0.5000000000000001,
        0.16666666666666669,
        0.041666666666623824,
        0.008333333333330039,
        0.0013888888917367081,
        0.00019841269863171557,
        2.4801521057868204e-05,
        2.7557268276905696e-06,
        2.7620201591031547e-07,
        2.5100472505694996e-08,
    ),
)
_FLOAT32 = _Tables(
    parts=(0.693145751953125, 1.4286068203094173e-06),
    lowest=-104.0,
    highest=89.0,
    fit=(0.5, 0.16666576666119928, 0.04166655421298415, 0.008363232883682618, 0.0013926250831497611),
)


def _tables(x: Scalar) -> _Tables:
    return _FLOAT32 if format_of(x) is FLOAT32 else _FLOAT64


@elementary(lambda x, y: y)
def exp(x: Scalar) -> Scalar:
    """e^x. Error: at most 1.0 unit in the last place in both types."""
    t = _tables(x)
    x = jnp.minimum(jnp.maximum(x, t.lowest), t.highest)
    k = jnp.round(x * (1.0 / math.log(2.0)))
    r = (x - k * t.parts[0]) - k * t.parts[1]
    return scaled(1.0 + (r + r * r * polynomial(r, t.fit)), k)


@elementary(lambda x, y: exp(x))
def expm1(x: Scalar) -> Scalar:
    """e^x − 1, with all digits near 0: what r loses to rounding is added to its square.

    Error: at most 1.8 (float64) or 1.9 (float32) units in the last place.
    """
    t = _tables(x)
    inside = jnp.minimum(jnp.maximum(x, -1.0 * format_of(x).digits), t.highest)
    k = jnp.round(inside * (1.0 / math.log(2.0)))
    first, second = inside - k * t.parts[0], k * t.parts[1]
    r = first - second
    rest = (first - r) - second
    half = power_of_two(k - 1.0)  # 2^k itself may be infinite
    y = 2.0 * (half * (r + (r * r * polynomial(r, t.fit) + rest)) + (half - 0.5))
    return jnp.where(jnp.abs(x) < 2.0 ** -(format_of(x).digits + 2), x, y)
