"""Logarithms by arithmetic only.

    x = 2^k m,  √½ ≤ m < √2
    f = m − 1,  s = f/(2 + f)
    ln(1 + f) = f − (f²/2 − s (f²/2 + s² P(s²)))
    ln x = k ln 2 + ln(1 + f)                     ln 2 is a sum of two parts, so k times the first has no rounding error

P: Chebyshev fit of (ln((1+s)/(1−s))/s − 2)/s² in s². The form is that of fdlibm (Sun Microsystems, 1993);
coefficients: tests/physics/test_elementary_fits.py.
"""

from __future__ import annotations

from typing import NamedTuple

from rvjax.elementary.formats import LN2, Real, arithmetic, bits, by_format, either, format_of, namespace, number, polynomial


class _Tables(NamedTuple):
    """parts: of ln 2. root: the bits of √½. fit: coefficients of P, from the lowest."""

    parts: tuple[float, float]
    root: int
    fit: tuple[float, ...]


_FLOAT64 = _Tables(
    parts=(0.693147180559663, 2.8235290563031577e-13),
    root=0x3FE6A09E667F3BCD,
    fit=(
        0.666666666666667,
        0.39999999999899455,
        0.2857142862599856,
        0.2222221113102852,
        0.1818288939967772,
        0.15331712479381301,
        0.14616562422104645,
    ),
)
_FLOAT32 = _Tables(
    parts=(0.693145751953125, 1.4286068203094173e-06),
    root=0x3F3504F3,
    fit=(0.6666668504421033, 0.3998877866920588, 0.2958003547825995),
)
_tables = by_format(_FLOAT64, _FLOAT32)


@arithmetic
def log(x: Real) -> Real:
    """ln x. −∞ at ±0, NaN below. Error: at most 0.8 units in the last place in both types."""
    k, f = split(x)
    t = _tables(x)
    return _by_sign(x, x, k * t.parts[0] - (_bend(f, k * t.parts[1]) - f))


@arithmetic
def log1p(x: Real) -> Real:
    """ln(1 + x), with all digits near 0: what 1 + x loses to rounding is added to f.

    Error: at most 1.3 units in the last place in both types.
    """
    xp = namespace(x)
    one = 1.0 + x
    most = 1.0 - one  # not one − 1, which XLA takes for x
    lost = (1.0 - (one + most)) + (x + most)
    k, f, shrink = split_normal(one)
    f = f + 0.5 * lost * shrink
    t = _tables(x)
    y = _by_sign(one, x, k * t.parts[0] - (_bend(f, k * t.parts[1]) - f))
    return xp.where(xp.abs(x) < 2.0 ** -(format_of(x).digits + 2), x, y)


@arithmetic
def log2(x: Real) -> Real:
    """The logarithm to base 2; whole where x is a power of two.

    Error: at most 1.6 (float64) or 1.7 (float32) units in the last place.
    """
    k, f = split(x)
    return _by_sign(x, x, k + (f - _bend(f, 0.0)) * (1.0 / LN2))


def split(x: Real) -> tuple[Real, Real]:
    """(k, f) of a number x > 0, also where it is below the smallest normal number."""
    xp = namespace(x)
    form = format_of(x)
    small = x < form.tiny
    k, f, _ = split_normal(xp.where(small, x * 2.0 ** (form.digits + 2), x))
    return xp.where(small, k - (form.digits + 2.0), k), f


def split_normal(x: Real) -> tuple[Real, Real, Real]:
    """(k, f, 2^(1−k)) of a normal number x > 0."""
    xp = namespace(x)
    form = format_of(x)
    whole = bits(x)
    exponent = (whole - _tables(x).root) >> form.digits
    field = exponent << form.digits
    k = number(exponent + bits(xp.asarray(form.ones, x.dtype))) - form.ones
    return k, number(whole - field) - 1.0, number(bits(xp.asarray(2.0, x.dtype)) - field)


def _bend(f: Real, more: Real) -> Real:
    """f − ln(1 + f) − more."""
    s = f / (2.0 + f)
    square = s * s
    half = 0.5 * f * f
    return half - (s * (half + square * polynomial(square, _tables(f).fit)) + more)


def _by_sign(argument: Real, x: Real, y: Real) -> Real:
    """y for an argument in (0, ∞); ∞ for ∞, −∞ for 0, NaN below and for NaN."""
    xp = namespace(argument)
    edge = either(argument == 0.0, -xp.inf, xp.nan, argument)
    return xp.where(argument > 0.0, xp.where(argument < xp.inf, y, x), edge)
