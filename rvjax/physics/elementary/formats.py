"""Bits of floating-point numbers (IEEE 754), and what all elementary functions share.

A number is (−1)^s 2^(e − bias) 1.f with a field of `digits` bits for f below the field of e. Two to the power of k is the number
whose field e is k + bias; k comes into that field by adding 1.5·2^digits, whose last bit counts ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce, wraps
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from rvjax.physics.vectors import Scalar


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


def format_of(x: Scalar) -> Format:
    """Errors: TypeError for a type other than float64 and float32."""
    name = str(jnp.result_type(x))
    for known in (FLOAT64, FLOAT32):
        if known.name == name:
            return known
    raise TypeError(f"an elementary function of {name} numbers: float64 and float32 are accepted")


def bits(x: Scalar) -> Scalar:
    """The bits of a number as an integer."""
    return jax.lax.bitcast_convert_type(x, format_of(x).whole)


def number(whole: Scalar) -> Scalar:
    """The number with these bits."""
    return jax.lax.bitcast_convert_type(whole, jnp.float64 if jnp.result_type(whole) == np.int64 else jnp.float32)


def with_sign(size: Scalar, x: Scalar) -> Scalar:
    """size ≥ 0 with the sign of x, that of zero too."""
    return number(bits(size) | (bits(x) & format_of(x).sign))


def with_sign_times(y: Scalar, x: Scalar) -> Scalar:
    """y with its sign changed where the sign of x is negative, that of zero too."""
    return number(bits(y) ^ (bits(x) & format_of(x).sign))


def head(x: Scalar, zeros: tuple[int, int]) -> Scalar:
    """x without its last bits, zeros of them in (float64, float32): products of two such numbers have no rounding error."""
    return number(bits(x) & -(1 << zeros[format_of(x) is FLOAT32]))


def power_of_two(k: Scalar) -> Scalar:
    """2ᵏ of a whole number k where it is a normal number."""
    form = format_of(k)
    return number(bits(k + (form.ones + form.bias)) << form.digits)


def scaled(x: Scalar, k: Scalar) -> Scalar:
    """2ᵏx of a whole number k, |k| ≤ 2 bias: by ⌊k/2⌋ and by the rest, so that only one product is rounded."""
    form = format_of(k)
    both = bits(k + (form.ones + 2 * form.bias))
    half = both >> 1
    return x * number(half << form.digits) * number((both - half) << form.digits)


def polynomial(x: Scalar, coefficients: Sequence[float]) -> Scalar:
    """c₀ + c₁x + c₂x² + …: Horner's rule in x² on the pairs c₀ + c₁x, c₂ + c₃x, …"""
    square = x * x
    pairs = [reduce(lambda low, high: low + high * x, coefficients[i : i + 2]) for i in range(0, len(coefficients), 2)]
    return reduce(lambda value, pair: value * square + pair, reversed(pairs))


def of_two(
    function: Callable[[Scalar, Scalar], Scalar], slopes: Callable[[Scalar, Scalar, Scalar], tuple[Scalar, Scalar]]
) -> Callable[[Scalar, Scalar], Scalar]:
    """A function of two arguments with its derivative: slopes(x, y, f(x, y)) = (∂f/∂x, ∂f/∂y)."""
    inner = jax.custom_jvp(jax.jit(function, inline=True))

    def rule(primals: tuple[Scalar, Scalar], tangents: tuple[Scalar, Scalar]) -> tuple[Scalar, Scalar]:
        value = inner(*primals)
        along_x, along_y = slopes(*primals, value)
        return value, along_x * tangents[0] + along_y * tangents[1]

    inner.defjvp(rule)
    return lambda x, y: evaluated(lambda *both: inner(*jnp.broadcast_arrays(*both)), x, y)


def elementary(slope: Callable[[Scalar, Scalar], Scalar]) -> Callable[[Callable[[Scalar], Scalar]], Callable[[Scalar], Scalar]]:
    """Gives a function f of one argument its derivative: slope(x, f(x)) = f'(x). Bits have none."""

    def decorate(function: Callable[[Scalar], Scalar]) -> Callable[[Scalar], Scalar]:
        inner = jax.custom_jvp(jax.jit(function, inline=True))

        def rule(primals: tuple[Scalar], tangents: tuple[Scalar]) -> tuple[Scalar, Scalar]:
            y = inner(*primals)
            return y, slope(*primals, y) * tangents[0]

        inner.defjvp(rule)

        @wraps(function)
        def outer(x: Scalar) -> Scalar:
            return evaluated(inner, x)

        return outer

    return decorate


def evaluated(function: Callable[..., Scalar], *arguments: Scalar) -> Scalar:
    """function(*arguments) in their common type. Python numbers give a number that takes the type of what it meets, as in jnp."""
    if all(type(x) in (bool, int, float) for x in arguments):
        with jax.ensure_compile_time_eval():
            return jnp.asarray(float(function(*(jnp.asarray(float(x)) for x in arguments))))
    dtype = jnp.result_type(*arguments)
    dtype = dtype if jnp.issubdtype(dtype, jnp.floating) else jnp.result_type(float)
    return function(*(jnp.asarray(x, dtype=dtype) for x in arguments))
