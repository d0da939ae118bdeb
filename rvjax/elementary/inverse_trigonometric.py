"""Inverse trigonometric functions by arithmetic only.

    atan |x| = c + atan t,  |t| ≤ ½               atan t = t + t³ P(t²)
        |x| ≤ ½         c = 0       t = |x|
        ½ < |x| ≤ 2     c = π/4     t = (|x| − 1)/(|x| + 1)
        2 < |x|         c = π/2     t = −1/|x|
    asin |x| = a(|x|) for |x| ≤ ½, π/2 − 2 a(√((1 − |x|)/2)) beyond          a(s) = s + s³ Q(s²)
    acos x   = π/2 − a(x) for |x| ≤ ½, 2 a(√((1 − x)/2)) for x > ½, π − 2 a(√((1 + x)/2)) for x < −½

π is a sum of two numbers. P, Q: Chebyshev fits, relative errors 1e-18 and 4e-18 (float64) or 1.1e-9 (float32);
tests/physics/test_elementary_fits.py.
"""

from __future__ import annotations

from typing import NamedTuple

from rvjax.elementary.formats import Real, arithmetic, bits, by_format, either, format_of, namespace, polynomial, with_sign


class _Tables(NamedTuple):
    """quarter: π/4 as a sum, the first with two bits to spare. tangent, sine: coefficients of P and Q, from the lowest."""

    quarter: tuple[float, float]
    tangent: tuple[float, ...]
    sine: tuple[float, ...]


_FLOAT64 = _Tables(
    quarter=(0.7853981633974483, 3.061616997868383e-17),
    tangent=(
        -0.3333333333333333,
        0.19999999999999485,
        -0.1428571428559874,
        0.11111111100881761,
        -0.09090908618865388,
        0.07692294677482635,
        -0.06666435144143137,
        0.05879573107799684,
        -0.052400641544110685,
        0.04627870086418654,
        -0.03806224794996687,
        0.024999689507521367,
        -0.009211063504627926,
    ),
    sine=(
        0.16666666666666669,
        0.07499999999998425,
        0.04464285714637338,
        0.030381944137085216,
        0.022372173002005596,
        0.017352391265909227,
        0.013971235301124539,
        0.011478952690257387,
        0.010324318288744113,
        0.00545087818772055,
        0.017419357964884856,
        -0.014881409392818066,
        0.02877844261259304,
    ),
)
_FLOAT32 = _Tables(
    quarter=(0.785398006439209, 1.5695823932524066e-07),
    tangent=(
        -0.33333332900544843,
        0.19999875028124872,
        -0.1427979292132035,
        0.11006776996857187,
        -0.08234976284155203,
        0.04224749976425588,
    ),
    sine=(
        0.1666666633654049,
        0.07500094761172901,
        0.04459931916287114,
        0.031101727829067168,
        0.017143716819253568,
        0.03370072632136513,
    ),
)
_tables = by_format(_FLOAT64, _FLOAT32)


@arithmetic
def atan(x: Real) -> Real:
    """atan x in rad, odd in every bit. Error: at most 1.4 units in the last place in both types."""
    xp = namespace(x)
    size = xp.abs(x)
    far, middle = size > 2.0, size > 0.5
    above = xp.where(far, -1.0, xp.where(middle, size - 1.0, size))
    t = above / xp.where(far, size, xp.where(middle, size + 1.0, 1.0))
    return with_sign(_angle(either(far, 2.0, xp.where(middle, 1.0, 0.0), x), 1.0, t), x)


@arithmetic
def atan2(y: Real, x: Real) -> Real:
    """The angle of the vector (x, y) from the axis of x, in (−π, π], in rad; ±π and ±0 on that axis have the sign of y.

    Error: at most 1.5 (float64) or 1.4 (float32) units in the last place.
    """
    xp = namespace(y)
    tall, wide = xp.abs(y), xp.abs(x)
    less, more = xp.minimum(tall, wide), xp.maximum(tall, wide)
    infinite = less == xp.inf
    less, more = xp.where(infinite, 1.0, less), xp.where(infinite, 1.0, more)
    scale = either(more > 2.0 ** (format_of(x).bias - 3), 0.25, 1.0, x)  # less + more stays finite
    less, more = less * scale, more * scale
    middle = less > 0.5 * more
    below = xp.where(middle, less + more, more)
    t = xp.where(middle, less - more, less) / xp.where(below == 0.0, 1.0, below)
    steep, back = tall > wide, bits(x) < 0
    quarters = either(middle, 1.0, 0.0, x)
    quarters = xp.where(steep, 2.0 - quarters, quarters)
    quarters = xp.where(back, 4.0 - quarters, quarters)
    return with_sign(_angle(quarters, either(steep ^ back, -1.0, 1.0, x), t), y)


@arithmetic
def asin(x: Real) -> Real:
    """asin x in rad, odd in every bit; NaN for |x| > 1. Error: at most 1.6 units in the last place in both types."""
    xp = namespace(x)
    size = xp.abs(x)
    far, s, tail = _from_end(size)
    first, second = _tables(x).quarter
    beyond = 2.0 * first - (2.0 * s + (2.0 * tail - 2.0 * second))
    return with_sign(xp.where(far, beyond, s + tail), x)


@arithmetic
def acos(x: Real) -> Real:
    """acos x in rad; NaN for |x| > 1. Error: at most 1.1 units in the last place in both types."""
    xp = namespace(x)
    far, s, tail = _from_end(xp.abs(x))
    first, second = _tables(x).quarter
    signed, curved = with_sign(s, x), with_sign(tail, x)
    inside = 2.0 * first - (signed - (2.0 * second - curved))
    beyond = xp.where(x > 0.0, 2.0 * (s + tail), 4.0 * first - (2.0 * s + (2.0 * tail - 4.0 * second)))
    return xp.where(far, beyond, inside)


def _from_end(size: Real) -> tuple[Real, Real, Real]:
    """(|x| > ½, s, a(s) − s)."""
    xp = namespace(size)
    far = size > 0.5
    square = xp.where(far, 0.5 * (1.0 - size), size * size)
    s = xp.where(far, xp.sqrt(square), size)
    return far, s, s * square * polynomial(square, _tables(size).sine)


def _angle(quarters: Real, sign: Real, t: Real) -> Real:
    """quarters π/4 + sign atan t."""
    tables = _tables(t)
    square = t * t
    tail = t * square * polynomial(square, tables.tangent)
    first, second = tables.quarter
    return quarters * first + (sign * t + (sign * tail + quarters * second))
