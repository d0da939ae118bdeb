"""Inverse hyperbolic functions through ln(1 + x), with all digits near 0.

    asinh |x| = ln(1 + w),  w = |x| + x²/(1 + √(1 + x²))
    acosh x   = ln(1 + w),  w = u + √(u² + 2u),  u = x − 1
    atanh |x| = ½ ln(1 + 2|x|/(1 − |x|))

For large x, whose square may overflow, ln x + ln 2 stands for the first two.
"""

from __future__ import annotations

import math

import jax.numpy as jnp

from rvjax.physics.elementary.formats import elementary, format_of, with_sign
from rvjax.physics.elementary.logarithms import log1p
from rvjax.physics.vectors import Scalar


@elementary(lambda x, y: 1.0 / jnp.sqrt(1.0 + x * x))
def asinh(x: Scalar) -> Scalar:
    """asinh x, odd in every bit. Error: at most 1.7 (float64) or 1.6 (float32) units in the last place."""
    size = jnp.abs(x)
    square = size * size
    return with_sign(_logarithm(size, size + square / (1.0 + jnp.sqrt(1.0 + square))), x)


@elementary(lambda x, y: 1.0 / (jnp.sqrt(x - 1.0) * jnp.sqrt(x + 1.0)))
def acosh(x: Scalar) -> Scalar:
    """acosh x ≥ 0; NaN below 1. Error: at most 1.9 (float64) or 2.0 (float32) units in the last place."""
    above = x - 1.0
    y = _logarithm(x, above + jnp.sqrt(above * above + (above + above)))
    return jnp.where(x < 1.0, jnp.nan, y)


@elementary(lambda x, y: 1.0 / ((1.0 - x) * (1.0 + x)))
def atanh(x: Scalar) -> Scalar:
    """atanh x, odd in every bit; ±∞ at ±1, NaN beyond.

    Error: at most 1.8 (float64) or 2.0 (float32) units in the last place.
    """
    size = jnp.abs(x)
    return with_sign(0.5 * log1p((size + size) / (1.0 - size)), x)


def _logarithm(size: Scalar, w: Scalar) -> Scalar:
    """ln(1 + w), of large numbers ln size + ln 2."""
    large = size > 2.0 ** (format_of(size).digits // 2 + 2)
    return log1p(jnp.where(large, size - 1.0, w)) + jnp.where(large, math.log(2.0), 0.0)
