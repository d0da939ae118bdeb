"""Exponential functions by arithmetic only.

    k = the integer nearest to x/ln 2
    r = x − k ln 2,  |r| ≤ ln 2/2                 ln 2 is a sum of two parts, so k times the first has no rounding error
    e^x = 2^k (1 + r + r² P(r))
    e^x − 1 = (2^k − 1) + 2^k (r + r² P(r))
    2^x = 2^k (1 + g Q(g)),  g = x − k

P: Chebyshev fit over |r| ≤ ln 2/2, error of e^r 1e-17 (float64) or 8e-9 (float32). 2^k is a product of two numbers, so that
results below the smallest normal number are rounded only once. W. Cody, W. Waite, "Software manual for the elementary functions",
1980, ch. 6; coefficients: tests/physics/test_elementary_fits.py.
"""

from __future__ import annotations

from typing import NamedTuple

from rvjax.elementary.formats import LN2, Real, arithmetic, by_format, format_of, namespace, polynomial, power_of_two, scaled


class _Tables(NamedTuple):
    """parts: of ln 2. lowest, highest: e^x is 0 or ∞ beyond. fit, base_two: coefficients of P and Q, from the lowest."""

    parts: tuple[float, float]
    lowest: float
    highest: float
    fit: tuple[float, ...]
    base_two: tuple[float, ...]


_FLOAT64 = _Tables(
    parts=(0.693147180559663, 2.8235290563031577e-13),
    lowest=-746.0,
    highest=711.0,
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
    base_two=(
        0.6931471805599453,
        0.24022650695910097,
        0.0555041086648216,
        0.009618129107606854,
        0.0013333558146416917,
        0.00015403530441794136,
        1.525273382986708e-05,
        1.3215442552522291e-06,
        1.0178062426976924e-07,
        7.072593027878997e-09,
        4.4549643712692967e-10,
    ),
)
_FLOAT32 = _Tables(
    parts=(0.693145751953125, 1.4286068203094173e-06),
    lowest=-104.0,
    highest=90.0,
    fit=(0.5, 0.16666576666119928, 0.04166655421298415, 0.008363232883682618, 0.0013926250831497611),
    base_two=(
        0.6931471880352003,
        0.24022650760645808,
        0.05550357071152507,
        0.009618082519990467,
        0.0013390886332106697,
        0.0001545318282995974,
    ),
)
_tables = by_format(_FLOAT64, _FLOAT32)


@arithmetic
def exp2(x: Real) -> Real:
    """2^x; a whole x gives a power of two. Error: at most 1.2 units in the last place in both types."""
    xp = namespace(x)
    t, form = _tables(x), format_of(x)
    x = xp.minimum(xp.maximum(x, -1.0 * (form.bias + form.digits + 2)), form.bias + 2.0)
    k = xp.round(x)
    rest = x - k
    return scaled(1.0 + rest * polynomial(rest, t.base_two), k)


def exp_of_sum(x: Real, rest: Real) -> Real:
    """e^(x + rest) − 1 for |x| ≤ ln 2/2 and a rest below the last place of x."""
    return x + (x * x * polynomial(x, _tables(x).fit) + (rest + x * rest))


def _parts(x: Real) -> tuple[Real, Real]:
    """(m, k): e^x = 2^k m."""
    xp = namespace(x)
    t = _tables(x)
    x = xp.minimum(xp.maximum(x, t.lowest), t.highest)
    k = xp.round(x * (1.0 / LN2))
    r = (x - k * t.parts[0]) - k * t.parts[1]
    return 1.0 + (r + r * r * polynomial(r, t.fit)), k


@arithmetic
def exp(x: Real) -> Real:
    """e^x. Error: at most 1.0 unit in the last place in both types."""
    mantissa, k = _parts(x)
    return scaled(mantissa, k)


def half_exp(x: Real) -> Real:
    """e^x/2, finite also where e^x is not."""
    mantissa, k = _parts(x)
    return scaled(mantissa, k - 1.0)


@arithmetic
def expm1(x: Real) -> Real:
    """e^x − 1, with all digits near 0: what r loses to rounding is added to its square.

    Error: at most 1.8 (float64) or 1.9 (float32) units in the last place.
    """
    xp = namespace(x)
    t = _tables(x)
    inside = xp.minimum(xp.maximum(x, -1.0 * format_of(x).digits), t.highest - 1.0)
    k = xp.round(inside * (1.0 / LN2))
    first, second = inside - k * t.parts[0], k * t.parts[1]
    r = first - second
    rest = (first - r) - second
    half = power_of_two(k - 1.0)  # 2^k itself may be infinite
    y = 2.0 * (half * (r + (r * r * polynomial(r, t.fit) + rest)) + (half - 0.5))
    return xp.where(xp.abs(x) < 2.0 ** -(format_of(x).digits + 2), x, y)
