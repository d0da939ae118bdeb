"""Sine and cosine by arithmetic only, on whole vector registers. The compiler would call the C library for each number.

    q = the integer nearest to x/(π/2) among the even (sine) or odd (cosine) ones
    r = x − q π/2,  |r| ≤ π/2         π/2 is a sum of short parts, so q times a part has no rounding error
    sin x = (−1)^(q/2) sin r          cos x = −(−1)^((q−1)/2) sin r
    sin r = r + r³ P(r²)              P: Chebyshev fit over |r| ≤ π/2, error 3e-19 (float64) or 3e-11 (float32)

Error: at most 2.5 units in the last place for |x| ≤ 2e8 rad (float64) or 1e4 rad (float32). Beyond that it is the sine of a
number within a unit in the last place of x, as long as |x|/π ≤ 2^(digits − 1); |sin x| never exceeds 1. NaN for NaN and ±∞.
W. Cody, W. Waite, "Software manual for the elementary functions", 1980, ch. 8; coefficients:
tests/physics/test_sine_and_cosine.py.
"""

from __future__ import annotations

import math
from functools import reduce
from typing import NamedTuple

from rvjax.elementary.formats import Real, arithmetic, bits, by_format, format_of, namespace, number


class _Tables(NamedTuple):
    """parts: of π/2, from the largest. fit: coefficients of P, from the lowest."""

    parts: tuple[float, ...]
    fit: tuple[float, ...]


_FLOAT64 = _Tables(
    parts=(1.5707963109016418, 1.5893254712295857e-08, 6.123233932053594e-17, 6.36831716351095e-25),
    fit=(
        -0.16666666666666666,
        0.008333333333333316,
        -0.00019841269841254966,
        2.7557319219160833e-06,
        -2.505210761669045e-08,
        1.6058977292642743e-10,
        -7.643969663988074e-13,
        2.7314368769379893e-15,
    ),
)
_FLOAT32 = _Tables(
    parts=(1.5703125, 0.0004825592041015625, 1.2665987014770508e-06, 9.89530235528946e-10, 2.5633440682570896e-12),
    fit=(-0.1666666666387985, 0.008333332768529359, -0.0001984108650700057, 2.753645944364609e-06, -2.408009508712208e-08),
)
_tables = by_format(_FLOAT64, _FLOAT32)


@arithmetic
def sin(x: Real) -> Real:
    """sin x; x in rad."""
    xp = namespace(x)
    half = xp.round(x * (1.0 / math.pi))
    return _alternating(_sine(x, 2.0 * half), half)


@arithmetic
def cos(x: Real) -> Real:
    """cos x; x in rad."""
    xp = namespace(x)
    half = xp.round(x * (1.0 / math.pi) - 0.5)
    return -_alternating(_sine(x, 2.0 * half + 1.0), half)


def _alternating(y: Real, n: Real) -> Real:
    """(−1)ⁿ y of a whole number n: the last bit of n + 1.5·2^digits, which counts ones, changes the sign."""
    odd = bits(n + format_of(n).ones) << (8 * n.dtype.itemsize - 1)
    return number(bits(y) ^ odd)


def _sine(x: Real, quarters: Real) -> Real:
    """sin(x − quarters π/2) of a difference within ±π/2."""
    xp = namespace(x)
    tables = _tables(x)
    r = reduce(lambda rest, part: rest - quarters * part, tables.parts, x)
    r = xp.clip(r, -0.5 * math.pi, 0.5 * math.pi)
    square = r * r
    fit = reduce(lambda value, coefficient: value * square + coefficient, reversed(tables.fit))
    return r + r * square * fit
