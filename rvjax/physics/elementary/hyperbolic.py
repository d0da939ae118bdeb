"""Hyperbolic tangent by arithmetic only.

    k = the integer nearest to 2|x|/ln 2 − ¼,  s = 2^k
    r = |x| − k ln 2/2,  −ln 2/8 ≤ r ≤ 3 ln 2/8,  t = tanh r = r + r³ P(r²)
    tanh |x| = ((s − 1) + (s + 1) t)/((s + 1) + (s − 1) t)          k ≤ 2
             = 1 + (−2 + 2 t)/((s + 1) + (s − 1) t)                 k > 2, with fewer roundings

from tanh(a + b) = (tanh a + tanh b)/(1 + tanh a tanh b). With k = 0 it is t itself. P: Chebyshev fit, relative error of t 3e-17
(float64) or 2e-8 (float32); tests/physics/test_elementary_fits.py.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import jax.numpy as jnp

from rvjax.physics.elementary.formats import FLOAT32, elementary, format_of, polynomial, power_of_two, with_sign
from rvjax.physics.vectors import Scalar


class _Tables(NamedTuple):
    """parts: of ln 2/2. highest: tanh is 1 beyond. fit: coefficients of P, from the lowest."""

    parts: tuple[float, float]
    highest: float
    fit: tuple[float, ...]


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
)
_FLOAT32 = _Tables(
    parts=(0.3465728759765625, 7.143034101547086e-07),
    highest=10.0,
    fit=(-0.3333331297505319, 0.13327912157947672, -0.05181412651917776),
)


@elementary(lambda x, y: 1.0 - y * y)
def tanh(x: Scalar) -> Scalar:
    """tanh x, odd in every bit, |tanh x| ≤ 1. Error: at most 1.9 units in the last place in both types."""
    tables = _FLOAT32 if format_of(x) is FLOAT32 else _FLOAT64
    size = jnp.minimum(jnp.abs(x), tables.highest)
    k = jnp.round(size * (2.0 / math.log(2.0)) - 0.25)
    r = (size - k * tables.parts[0]) - k * tables.parts[1]
    square = r * r
    t = r + r * square * polynomial(square, tables.fit)
    s = power_of_two(k)
    low, high = s - 1.0, s + 1.0
    near = k < 3.0
    above = jnp.where(near, low, -2.0) + jnp.where(near, high, 2.0) * t
    return with_sign(jnp.where(near, 0.0, 1.0) + above / (high + low * t), x)
