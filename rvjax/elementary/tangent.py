"""Tangent by arithmetic only.

    n = the integer nearest to 4|x|/π
    r + c = |x| − n π/4,  |r| ≤ π/8               π/4 is a sum of short parts; c: what the differences lose to rounding
    t = tan(r + c) = r + (r³ P(r²) + c)
    tan |x| = t, (1 + t)/(1 − t), −1/t, −(1 − t)/(1 + t)         for n = 0, 1, 2, 3 modulo 4

What 1 + t and 1 − t lose to rounding is added to their quotient.

P: Chebyshev fit, relative error of t 8e-18 (float64) or 8e-9 (float32); tests/physics/test_elementary_fits.py. The parts are
half of those of sine and cosine.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from rvjax.elementary import trigonometric
from rvjax.elementary.formats import Real, arithmetic, by_format, namespace, polynomial, with_sign_times


class _Tables(NamedTuple):
    """parts: of π/2, from the largest. fit: coefficients of P, from the lowest."""

    parts: tuple[float, ...]
    fit: tuple[float, ...]


_FLOAT64 = _Tables(
    parts=trigonometric._FLOAT64.parts,
    fit=(
        0.33333333333333337,
        0.13333333333328182,
        0.05396825397713502,
        0.021869487947702732,
        0.008863255016103296,
        0.0035917667974308407,
        0.0014597459374592807,
        0.0005656138670090638,
        0.00031906006743818717,
    ),
)
_FLOAT32 = _Tables(
    parts=trigonometric._FLOAT32.parts,
    fit=(0.33333328863819534, 0.13334258045121553, 0.05367189728678659, 0.024859938396875444),
)
_tables = by_format(_FLOAT64, _FLOAT32)


@arithmetic
def tan(x: Real) -> Real:
    """tan x; x in rad, odd in every bit. NaN for ±∞.

    Error for |x| ≤ 1e8 rad (float64) or 1e4 rad (float32): at most 1.6 units in the last place. Beyond, digits are lost.
    """
    xp = namespace(x)
    tables = _tables(x)
    size = xp.abs(x)
    n = xp.round(size * (4.0 / math.pi))
    first, second, *others = (0.5 * part for part in tables.parts)
    r, lost = (size - n * first) - n * second, 0.0
    for part in others:
        less = r - n * part
        r, lost = less, lost + ((r - less) - n * part)
    r, lost = _within(r, 0.4), _within(lost, 1e-6)
    square = r * r
    t = r + (r * square * polynomial(square, tables.fit) + lost)
    quarter = n - 4.0 * xp.floor(0.25 * n)
    over, odd = quarter > 1.5, quarter - 2.0 * xp.floor(0.5 * quarter) > 0.5
    plus, minus = 1.0 + t, 1.0 - t
    a, b = xp.where(odd, plus, t), xp.where(odd, minus, 1.0)
    more_a, more_b = xp.where(odd, (1.0 - plus) + t, 0.0), xp.where(odd, (1.0 - minus) - t, 0.0)
    below = xp.where(over, a, b)
    quotient = xp.where(over, b, a) / below
    correction = xp.where(over, more_b, more_a) - quotient * xp.where(over, more_a, more_b)
    y = quotient + correction * (0.5 + 0.5 * quotient)  # 1/below = (1 + quotient)/2 for odd n
    return with_sign_times(xp.where(over, -y, y), x)


def _within(x: Real, limit: float) -> Real:
    xp = namespace(x)
    return xp.minimum(xp.maximum(x, -limit), limit)
