"""Inverse hyperbolic functions through ln(1 + x), with all digits near 0.

    asinh |x| = ln(1 + w),  w = |x| + x²/(1 + √(1 + x²))
    acosh x   = ln(1 + w),  w = u + √(u² + 2u),  u = x − 1
    atanh |x| = ½ ln(1 + 2|x|/(1 − |x|))

For large x, whose square may overflow, ln x + ln 2 stands for the first two.
"""

from __future__ import annotations

from rvjax.elementary.formats import LN2, Real, arithmetic, either, format_of, namespace, with_sign
from rvjax.elementary.logarithms import log1p


@arithmetic
def asinh(x: Real) -> Real:
    """asinh x, odd in every bit. Error: at most 1.7 (float64) or 1.6 (float32) units in the last place."""
    xp = namespace(x)
    size = xp.abs(x)
    square = size * size
    return with_sign(_logarithm(size, size + square / (1.0 + xp.sqrt(1.0 + square))), x)


@arithmetic
def acosh(x: Real) -> Real:
    """acosh x ≥ 0; NaN below 1. Error: at most 1.9 (float64) or 2.0 (float32) units in the last place."""
    xp = namespace(x)
    above = x - 1.0
    y = _logarithm(x, above + xp.sqrt(above * above + (above + above)))
    return xp.where(x < 1.0, xp.nan, y)


@arithmetic
def atanh(x: Real) -> Real:
    """atanh x, odd in every bit; ±∞ at ±1, NaN beyond.

    Error: at most 1.8 (float64) or 2.0 (float32) units in the last place.
    """
    xp = namespace(x)
    size = xp.abs(x)
    return with_sign(0.5 * log1p((size + size) / (1.0 - size)), x)


def _logarithm(size: Real, w: Real) -> Real:
    """ln(1 + w), of large numbers ln size + ln 2."""
    xp = namespace(size)
    large = size > 2.0 ** (format_of(size).digits // 2 + 2)
    return log1p(xp.where(large, size - 1.0, w)) + either(large, LN2, 0.0, w)
