"""Hyperbolic functions by arithmetic only.

    k = the integer nearest to 2|x|/ln 2 − ¼,  s = 2^k
    r = |x| − k ln 2/2,  −ln 2/8 ≤ r ≤ 3 ln 2/8,  t = tanh r = r + r³ P(r²)
    tanh |x| = ((s − 1) + (s + 1) t)/((s + 1) + (s − 1) t)          k ≤ 2
             = 1 + (−2 + 2 t)/((s + 1) + (s − 1) t)                 k > 2, with fewer roundings
    sinh |x| = |x| + |x|³ Q(x²) for |x| < 1, e^|x|/2 − e^−|x|/2 beyond
    cosh x   = e^|x|/2 + e^−|x|/2

tanh: from tanh(a + b) = (tanh a + tanh b)/(1 + tanh a tanh b); with k = 0 it is t itself. P, Q: Chebyshev fits, relative errors
3e-17 and 1e-18 (float64) or 2e-8 and 3e-10 (float32); tests/physics/test_elementary_fits.py.
"""

from __future__ import annotations

from typing import NamedTuple

from rvjax.elementary.exponential import half_exp
from rvjax.elementary.formats import LN2, Real, arithmetic, by_format, either, namespace, polynomial, power_of_two, with_sign


class _Tables(NamedTuple):
    """parts: of ln 2/2. highest: tanh is 1 beyond. fit, sine: coefficients of P and Q, from the lowest."""

    parts: tuple[float, float]
    highest: float
    fit: tuple[float, ...]
    sine: tuple[float, ...]


_FLOAT64 = _Tables(
    parts=(0.3465735902798315, 1.4117645281515789e-13),
    highest=20.0,
    fit=(
        -0.3333333333333329,
        0.13333333333271527,
        -0.05396825382196964,
        0.021869475534220868,
        -0.008862684033034684,
        0.0035800707491590762,
        -0.0013238204108108349,
    ),
    sine=(
        0.16666666666666666,
        0.008333333333333299,
        0.00019841269841324198,
        2.7557319191381816e-06,
        2.5052117695907823e-08,
        1.6057679623801638e-10,
        7.746178593018827e-13,
    ),
)
_FLOAT32 = _Tables(
    parts=(0.3465728759765625, 7.143034101547086e-07),
    highest=10.0,
    fit=(-0.3333331297505319, 0.13327912157947672, -0.05181412651917776),
    sine=(0.16666666646842135, 0.00833333967591706, 0.00019838101968683888, 2.8062802582276946e-06),
)
_tables = by_format(_FLOAT64, _FLOAT32)


@arithmetic
def tanh(x: Real) -> Real:
    """tanh x, odd in every bit, |tanh x| ≤ 1. Error: at most 1.9 units in the last place in both types."""
    xp = namespace(x)
    tables = _tables(x)
    size = xp.minimum(xp.abs(x), tables.highest)
    k = xp.round(size * (2.0 / LN2) - 0.25)
    r = (size - k * tables.parts[0]) - k * tables.parts[1]
    square = r * r
    t = r + r * square * polynomial(square, tables.fit)
    s = power_of_two(k)
    low, high = s - 1.0, s + 1.0
    near = k < 3.0
    above = xp.where(near, low, -2.0) + xp.where(near, high, 2.0) * t
    return with_sign(either(near, 0.0, 1.0, x) + above / (high + low * t), x)


@arithmetic
def sinh(x: Real) -> Real:
    """sinh x, odd in every bit. Error: at most 1.6 units in the last place in both types."""
    xp = namespace(x)
    size = xp.abs(x)
    square = size * size
    half = half_exp(size)
    near = size + size * square * polynomial(square, _tables(x).sine)
    return with_sign(xp.where(size < 1.0, near, half - 0.25 / half), x)


@arithmetic
def cosh(x: Real) -> Real:
    """cosh x, even in every bit. Error: at most 1.4 (float64) or 1.3 (float32) units in the last place."""
    xp = namespace(x)
    half = half_exp(xp.abs(x))
    return half + 0.25 / half
