"""Powers by arithmetic only: xⁿ, and x^y through a logarithm that is a sum of two numbers.

    log₂ x = n + d + (2/(3 ln 2)) (3s + s³ + s⁵ P(s²))      x = 2^n m, s = (m − b)/(m + b), b = 1 or 3/2, d = log₂ b
    z = y log₂ x, k = the integer nearest to z
    x^y = 2^k e^((z − k) ln 2)

log₂ x and z are sums of two numbers; products of their heads have no rounding error. The form is that of fdlibm (Sun
Microsystems, 1993). P: Chebyshev fit over |s| ≤ 0.101, relative error of the logarithm 4e-21 (float64) or 2e-10 (float32).
Coefficients: tests/physics/test_elementary_fits.py.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from rvjax.elementary.exponential import exp_of_sum
from rvjax.elementary.formats import (
    LN2,
    Real,
    arithmetic,
    bits,
    by_format,
    either,
    format_of,
    head,
    namespace,
    polynomial,
    scaled,
)
from rvjax.elementary.logarithms import split

_CUT = (32, 12)
"""Bits that a head of a logarithm lacks, (float64, float32)."""


class _Tables(NamedTuple):
    """factor: 2/(3 ln 2), base: log₂ 1.5, ln2, each as (head, rest). fit: coefficients of P."""

    factor: tuple[float, float]
    base: tuple[float, float]
    ln2: tuple[float, float]
    fit: tuple[float, ...]


_FLOAT64 = _Tables(
    factor=(0.9617966860532761, 7.872699542894897e-09),
    base=(0.5849624872207642, 1.350039202129749e-08),
    ln2=(0.6931471675634384, 1.2996506893889889e-08),
    fit=(
        0.5999999999999999,
        0.42857142857213787,
        0.33333333252377917,
        0.27272761039607346,
        0.23070564718152986,
        0.2055021192151487,
    ),
)
_FLOAT32 = _Tables(
    factor=(0.961669921875, 0.0001267720509756049),
    base=(0.5849609375, 1.5632211561814537e-06),
    ln2=(0.693115234375, 3.1946184945309415e-05),
    fit=(0.5999956153250473, 0.43200163347968806),
)
_tables = by_format(_FLOAT64, _FLOAT32)


def integer_power(x: Real, n: int) -> Real:
    """xⁿ for a fixed integer n by repeated squaring: the product of x^(2^i) over the bits i of |n|, from the lowest; its
    reciprocal for n < 0. Exactly what `jax.lax.integer_pow` computes.
    """

    @arithmetic
    def raised(x: Real) -> Real:
        rest, square, product = abs(n), x, None
        while rest:
            if rest & 1:
                product = square if product is None else product * square
            rest >>= 1
            square = square * square if rest else square
        product = namespace(x).ones_like(x) if product is None else product
        return 1.0 / product if n < 0 else product

    return raised(x)


@arithmetic
def power(x: Real, y: Real) -> Real:
    """x^y of two numbers of one type, special values as C99 has them.

    Error: at most 0.9 units in the last place in both types.
    """
    xp = namespace(x)
    form, size = format_of(x), xp.abs(x)
    far = 2.0 ** (form.digits + 12)
    size_of_power = _exponential(*_times(xp.minimum(xp.maximum(y, -far), far), *_log2(size)))
    up = y > 0.0
    value = xp.where(size == 0.0, either(up, 0.0, xp.inf, x), size_of_power)
    value = xp.where(size == xp.inf, either(up, xp.inf, 0.0, x), value)
    half = 0.5 * y
    whole = xp.floor(y) == y
    odd = whole & (xp.floor(half) != half)
    value = xp.where(odd & (bits(x) < 0), -value, value)
    number = (x == x) & (y == y) & (whole | (x >= 0.0) | (size == xp.inf))
    return xp.where((y == 0.0) | (x == 1.0), 1.0, xp.where(number, value, xp.nan))


def _log2(size: Real) -> tuple[Real, Real]:
    """log₂ of a number > 0 as the sum of a head and a rest."""
    xp = namespace(size)
    t = _tables(size)
    n, f = split(size)
    m = 1.0 + f
    low = m < 0.5 * math.sqrt(3.0)
    m, n = xp.where(low, m + m, m), xp.where(low, n - 1.0, n)
    upper = m > math.sqrt(1.5)
    b = either(upper, 1.5, 1.0, m)
    above, inverse = m - b, 1.0 / (m + b)
    s = above * inverse
    first = head(s, _CUT)
    below = head(m + b, _CUT)
    second = inverse * ((above - first * below) - first * (m - (below - b)))
    square = s * s
    bend = square * square * polynomial(square, t.fit) + second * (first + s)
    square = first * first
    three = head(3.0 + square + bend, _CUT)
    rest = bend - ((three - 3.0) - square)
    product, more = first * three, second * three + rest * s
    large = head(product + more, _CUT)
    small = more - (large - product)
    high = t.factor[0] * large
    tail = t.factor[1] * large + small * sum(t.factor) + either(upper, t.base[1], 0.0, m)
    base = either(upper, t.base[0], 0.0, m)
    total = head(((high + tail) + base) + n, _CUT)
    return total, tail - (((total - n) - base) - high)


def _times(y: Real, first: Real, second: Real) -> tuple[Real, Real]:
    """y (first + second) as a sum, within the exponents of numbers."""
    xp = namespace(y)
    cut = head(y, _CUT)
    low, high = (y - cut) * first + y * second, cut * first
    limit = 1.08 * format_of(y).bias + 26.0
    total = low + high
    inside = xp.abs(total) < limit
    bounded = xp.minimum(xp.maximum(total, -limit), limit)
    return xp.where(inside, high, bounded), xp.where(inside, low, 0.0)


def _exponential(high: Real, low: Real) -> Real:
    """2^(high + low)."""
    xp = namespace(high)
    t = _tables(high)
    k = xp.round(high + low)
    high = high - k
    cut = head(high + low, _CUT)
    first = cut * t.ln2[0]
    second = (low - (cut - high)) * LN2 + cut * t.ln2[1]
    total = first + second
    return scaled(1.0 + exp_of_sum(total, second - (total - first)), k)
