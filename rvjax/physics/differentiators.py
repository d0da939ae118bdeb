"""Differentiators of a channel: an estimate ν of α̇ from the signal α alone, with a state (ζ₀, ζ₁).

    levant     ζ̇₀ = ν,  ν = ζ₁ − 1.5 √L |ζ₀−α|^½ sgn(ζ₀−α),   ζ̇₁ = −1.1 L sgn(ζ₁−ν)
    filtered   ζ̇₀ = ν,  ν = ζ₁,   ζ̇₁ = ω² (α − ζ₀) − 2 ω ζ₁          (second-order filter, unit damping)
    none       ν = 0

Both start at ζ₀ = α(0), ζ₁ = 0. levant: exact after a finite time if |α̈| ≤ L (A. Levant, "Robust exact differentiation via
sliding mode technique", Automatica, 1998). L in unit of α per s², ω in rad/s.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import jax.numpy as jnp

from rvjax.physics.vectors import Scalar

Differentiator = Callable[[Scalar, Scalar, Scalar, Scalar, Scalar], tuple[Scalar, Scalar, Scalar]]
"""(α, ζ₀, ζ₁, L, ω) → (ν, ζ̇₀, ζ̇₁)."""


def levant(a: Scalar, z0: Scalar, z1: Scalar, bound: Scalar, omega: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """ν = ζ₁ − 1.5 √L |ζ₀−α|^½ sgn(ζ₀−α),  ζ̇₀ = ν,  ζ̇₁ = −1.1 L sgn(ζ₁−ν)."""
    del omega
    error = z0 - a
    estimate = z1 - 1.5 * jnp.sqrt(bound * jnp.abs(error)) * jnp.sign(error)
    return estimate, estimate, -1.1 * bound * jnp.sign(z1 - estimate)


def filtered(a: Scalar, z0: Scalar, z1: Scalar, bound: Scalar, omega: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """ν = ζ₁,  ζ̇₀ = ζ₁,  ζ̇₁ = ω² (α − ζ₀) − 2 ω ζ₁."""
    del bound
    return z1, z1, omega * (omega * (a - z0) - 2.0 * z1)


def none(a: Scalar, z0: Scalar, z1: Scalar, bound: Scalar, omega: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """ν = 0."""
    del a, bound, omega
    zero = jnp.zeros_like(z0)
    return zero, zero, jnp.zeros_like(z1)


DIFFERENTIATORS: Mapping[str, Differentiator] = {"levant": levant, "filtered": filtered, "none": none}
