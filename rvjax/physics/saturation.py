"""Actuator saturation of a channel: the commanded wrench h(v) inside (−u⁻, u⁺) and its slope h'(v).

    smooth-tanh    h = u_m tanh(v/u_m),            h' = 1 − tanh²(v/u_m),        u_m = u⁺ for v ≥ 0, u⁻ for v < 0
    shifted-tanh   h = s tanh((v−c)/s) + c,        h' = 1 − tanh²((v−c)/s),      c = (u⁺−u⁻)/2, s = (u⁺+u⁻)/2
    erf            h = u_m erf(√π v/(2u_m)),       h' = exp(−π v²/(4u_m²))
    hard-clip      h = min(max(v, −u⁻), u⁺),       h' = 1 inside, 0 outside

The modified smooth hyperbolic tangent with asymmetric limits is from the paper (Xia, Huo, 2018); this form is a
reconstruction: h(0) = 0, h'(0) = 1 and h is twice continuously differentiable. The shifted tanh does not pass through zero.
The hard clip is the true actuator, which the smooth forms approximate.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import jax.numpy as jnp

from rvjax.physics.elementary import erf, exp, tanh
from rvjax.physics.vectors import Channels, Scalar, split

Saturation = Callable[[Scalar, Scalar, Scalar], tuple[Scalar, Scalar]]
"""(v, u⁺ > 0, u⁻ > 0) → (h, h') of a channel, all in its unit (N or N·m)."""


def smooth_tanh(v: Scalar, upper: Scalar, lower: Scalar) -> tuple[Scalar, Scalar]:
    """h = u_m tanh(v/u_m), h' = 1 − tanh²(v/u_m), u_m = u⁺ for v ≥ 0, else u⁻."""
    limit, inverse = _limit(v, upper, lower)
    share = tanh(v * inverse)
    return limit * share, 1.0 - share * share


def shifted_tanh(v: Scalar, upper: Scalar, lower: Scalar) -> tuple[Scalar, Scalar]:
    """h = s tanh((v−c)/s) + c, h' = 1 − tanh²((v−c)/s), c = (u⁺−u⁻)/2, s = (u⁺+u⁻)/2."""
    centre, span = 0.5 * (upper - lower), 0.5 * (upper + lower)
    share = tanh((v - centre) * (1.0 / span))
    return span * share + centre, 1.0 - share * share


def error_function(v: Scalar, upper: Scalar, lower: Scalar) -> tuple[Scalar, Scalar]:
    """h = u_m erf(√π v/(2u_m)), h' = exp(−π v²/(4u_m²)), u_m = u⁺ for v ≥ 0, else u⁻."""
    limit, inverse = _limit(v, upper, lower)
    x = (0.5 * math.sqrt(math.pi)) * v * inverse
    return limit * erf(x), exp(-(x * x))


def hard_clip(v: Scalar, upper: Scalar, lower: Scalar) -> tuple[Scalar, Scalar]:
    """h = min(max(v, −u⁻), u⁺); h' = 1 strictly inside the limits, 0 outside."""
    inside = (v < upper) & (v > -lower)
    return jnp.clip(v, -lower, upper), jnp.where(inside, 1.0, 0.0)


def _limit(v: Scalar, upper: Scalar, lower: Scalar) -> tuple[Scalar, Scalar]:
    """(u_m, 1/u_m). The limits do not change in a flight, so an engine divides once and not at every instant."""
    return jnp.where(v >= 0, upper, lower), jnp.where(v >= 0, 1.0 / upper, 1.0 / lower)


def saturate(saturation: Saturation, v: Channels, upper: Channels, lower: Channels) -> tuple[Channels, Channels]:
    """(h(v), h'(v)) channel by channel; upper, lower: magnitudes of the limits [N, N·m]."""
    h, slope = split(saturation, v, upper, lower)
    return h, slope
