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
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import jax.numpy as jnp

from rvjax.physics.elementary.exponential import exp_of_sum
from rvjax.physics.elementary.formats import (
    FLOAT32,
    bits,
    elementary,
    format_of,
    head,
    of_two,
    polynomial,
    scaled,
)
from rvjax.physics.elementary.logarithms import log, split
from rvjax.physics.vectors import Scalar

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


def integer_power(x: Scalar, n: int) -> Scalar:
    """xⁿ for a fixed integer n by repeated squaring: the product of x^(2^i) over the bits i of |n|, from the lowest; its
    reciprocal for n < 0. Exactly what `jax.lax.integer_pow` computes.
    """
    return _integer_power(n)(x)


def power(x: Scalar, y: Scalar) -> Scalar:
    """x^y, special values as C99 has them. ∂/∂y is 0 for x ≤ 0, where only whole y give numbers.

    Error: at most 0.9 units in the last place in both types.
    """
    return _power(x, y)


@cache
def _integer_power(n: int) -> Callable[[Scalar], Scalar]:
    def slope(x: Scalar, y: Scalar) -> Scalar:
        return n * integer_power(x, n - 1) if n else jnp.zeros_like(y)

    @elementary(slope)
    def raised(x: Scalar) -> Scalar:
        rest, square, product = abs(n), x, None
        while rest:
            if rest & 1:
                product = square if product is None else product * square
            rest >>= 1
            square = square * square if rest else square
        product = jnp.ones_like(x) if product is None else product
        return 1.0 / product if n < 0 else product

    return raised


def _raised(x: Scalar, y: Scalar) -> Scalar:
    """x^y of two numbers of one type."""
    form, size = format_of(x), jnp.abs(x)
    far = 2.0 ** (form.digits + 12)
    size_of_power = _exponential(*_times(jnp.minimum(jnp.maximum(y, -far), far), *_log2(size)))
    up = y > 0.0
    value = jnp.where(size == 0.0, jnp.where(up, 0.0, jnp.inf), size_of_power)
    value = jnp.where(size == jnp.inf, jnp.where(up, jnp.inf, 0.0), value)
    half = 0.5 * y
    whole = jnp.floor(y) == y
    odd = whole & (jnp.floor(half) != half)
    value = jnp.where(odd & (bits(x) < 0), -value, value)
    number = (x == x) & (y == y) & (whole | (x >= 0.0) | (size == jnp.inf))
    return jnp.where((y == 0.0) | (x == 1.0), 1.0, jnp.where(number, value, jnp.nan))


def _log2(size: Scalar) -> tuple[Scalar, Scalar]:
    """log₂ of a number > 0 as the sum of a head and a rest."""
    t = _tables(size)
    n, f = split(size)
    m = 1.0 + f
    low = m < 0.5 * math.sqrt(3.0)
    m, n = jnp.where(low, m + m, m), jnp.where(low, n - 1.0, n)
    upper = m > math.sqrt(1.5)
    b = jnp.where(upper, 1.5, 1.0)
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
    tail = t.factor[1] * large + small * sum(t.factor) + jnp.where(upper, t.base[1], 0.0)
    base = jnp.where(upper, t.base[0], 0.0)
    total = head(((high + tail) + base) + n, _CUT)
    return total, tail - (((total - n) - base) - high)


def _times(y: Scalar, first: Scalar, second: Scalar) -> tuple[Scalar, Scalar]:
    """y (first + second) as a sum, within the exponents of numbers."""
    cut = head(y, _CUT)
    low, high = (y - cut) * first + y * second, cut * first
    limit = 1.08 * format_of(y).bias + 26.0
    total = low + high
    inside = jnp.abs(total) < limit
    bounded = jnp.minimum(jnp.maximum(total, -limit), limit)
    return jnp.where(inside, high, bounded), jnp.where(inside, low, 0.0)


def _exponential(high: Scalar, low: Scalar) -> Scalar:
    """2^(high + low)."""
    t = _tables(high)
    k = jnp.round(high + low)
    high = high - k
    cut = head(high + low, _CUT)
    first = cut * t.ln2[0]
    second = (low - (cut - high)) * math.log(2.0) + cut * t.ln2[1]
    total = first + second
    return scaled(1.0 + exp_of_sum(total, second - (total - first)), k)


def _power_slopes(x: Scalar, y: Scalar, value: Scalar) -> tuple[Scalar, Scalar]:
    along_x = jnp.where(y == 0.0, 0.0, y * power(x, jnp.where(y == 0.0, 1.0, y - 1.0)))
    return along_x, value * log(jnp.where(x > 0.0, x, 1.0))


_power = of_two(_raised, _power_slopes)


def _tables(x: Scalar) -> _Tables:
    return _FLOAT32 if format_of(x) is FLOAT32 else _FLOAT64
