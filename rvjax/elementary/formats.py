"""Bits of floating-point numbers (IEEE 754), and what all elementary functions share.

A number is (−1)^s 2^(e − bias) 1.f with a field of `digits` bits for f below the field of e. Two to the power of k is the number
whose field e is k + bias; k comes into that field by adding 1.5·2^digits, whose last bit counts ones.

A function is written once, in the operations of the Python array API: the namespace of its argument, NumPy's or JAX's, does them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce, wraps
from typing import Any, NamedTuple, TypeVar

import numpy as np

T = TypeVar("T")

Real = Any
"""A number, or an array of NumPy's or JAX's."""

LN2 = 0.6931471805599453
"""ln 2, rounded."""

_HOST = (np.ndarray, np.generic, int, float)
"""Types that NumPy computes with. Arrays of other types name their namespace."""


class Format(NamedTuple):
    """whole: integers of the same width. digits: bits of the fraction. tiny: smallest normal number."""

    name: str
    whole: type[np.signedinteger[Any]]
    digits: int
    bias: int
    tiny: float

    @property
    def ones(self) -> float:
        """1.5·2^digits: its last bit counts ones."""
        return 1.5 * 2.0**self.digits

    @property
    def sign(self) -> np.signedinteger[Any]:
        """The bit of the sign."""
        return self.whole(np.iinfo(self.whole).min)


FLOAT64 = Format("float64", np.int64, 52, 1023, 2.0**-1022)
FLOAT32 = Format("float32", np.int32, 23, 127, 2.0**-126)


def arithmetic(function: Callable[..., Real]) -> Callable[..., Real]:
    """The function for NumPy's callers too: numbers and arrays of any shapes, in their common type, float64 of whole numbers.

    Without an array among them it gives a number. Overflow and invalid operations raise no warning. What is not NumPy's passes.
    """

    @wraps(function)
    def outer(*arguments: Real) -> Real:
        if not all(isinstance(x, _HOST) for x in arguments):
            return function(*arguments)
        kind = np.result_type(*arguments)
        rows = np.broadcast_arrays(*(np.asarray(x, kind if kind.kind == "f" else np.float64) for x in arguments))
        with np.errstate(all="ignore"):
            return function(*(np.atleast_1d(row) for row in rows)).reshape(rows[0].shape)[()]

    return outer


def namespace(x: Real) -> Any:
    """The functions for arrays of this kind."""
    return x.__array_namespace__()


def either(condition: Real, yes: Real, no: Real, x: Real) -> Real:
    """One of two constants, in the type of x."""
    return namespace(x).where(condition, yes, no).astype(x.dtype)


def format_of(x: Real) -> Format:
    """Errors: TypeError for a type other than float64 and float32."""
    for known in (FLOAT64, FLOAT32):
        if known.name == x.dtype:
            return known
    raise TypeError(f"an elementary function of {x.dtype} numbers: float64 and float32 are accepted")


def only_float64(x: Real) -> None:
    """Errors: TypeError for another type."""
    if format_of(x) is not FLOAT64:
        raise TypeError(f"a function of {x.dtype} numbers: float64 is accepted")


def by_format(in_float64: T, in_float32: T) -> Callable[[Real], T]:
    """x → the coefficients for its type."""
    return lambda x: in_float32 if format_of(x) is FLOAT32 else in_float64


def bits(x: Real) -> Real:
    """The bits of a number as an integer."""
    return x.view(format_of(x).whole)


def number(whole: Real) -> Real:
    """The number with these bits."""
    return whole.view(np.float64 if whole.dtype == np.int64 else np.float32)


def with_sign(size: Real, x: Real) -> Real:
    """size ≥ 0 with the sign of x, that of zero too."""
    return number(bits(size) | (bits(x) & format_of(x).sign))


def with_sign_times(y: Real, x: Real) -> Real:
    """y with its sign changed where the sign of x is negative, that of zero too."""
    return number(bits(y) ^ (bits(x) & format_of(x).sign))


def head(x: Real, zeros: tuple[int, int]) -> Real:
    """x without its last bits, zeros of them in (float64, float32): products of two such numbers have no rounding error."""
    return number(bits(x) & -(1 << zeros[format_of(x) is FLOAT32]))


def power_of_two(k: Real) -> Real:
    """2ᵏ of a whole number k where it is a normal number."""
    form = format_of(k)
    return number(bits(k + (form.ones + form.bias)) << form.digits)


def scaled(x: Real, k: Real) -> Real:
    """2ᵏx of a whole number k, |k| ≤ 2 bias: by ⌊k/2⌋ and by the rest, so that only one product is rounded."""
    form = format_of(k)
    both = bits(k + (form.ones + 2 * form.bias))
    half = both >> 1
    return x * number(half << form.digits) * number((both - half) << form.digits)


def polynomial(x: Real, coefficients: Sequence[float]) -> Real:
    """c₀ + c₁x + c₂x² + …: Horner's rule in x² on the pairs c₀ + c₁x, c₂ + c₃x, …"""
    square = x * x
    pairs = [reduce(lambda low, high: low + high * x, coefficients[i : i + 2]) for i in range(0, len(coefficients), 2)]
    return reduce(lambda value, pair: value * square + pair, reversed(pairs))
