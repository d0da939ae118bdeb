"""Discrete-time regulator and filter of a double integrator, by the algebraic Riccati equation.

    A = [1 T; 0 1],   B = [T²/2; T]
    S = H + AᵀS(I + GS)⁻¹A,   by doubling:   W = (I + G_k H_k)⁻¹,   A_{k+1} = A_k W A_k,   G_{k+1} = G_k + A_k W G_k A_kᵀ,
                                             H_{k+1} = H_k + A_kᵀ H_k W A_k → S

E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang, "Structure-preserving algorithms for periodic discrete-time algebraic Riccati
equations", Int. J. Control, 2004.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

DOUBLINGS = 30
"""Enough for a closed loop of 10⁹ periods."""


def riccati(a: Any, g: Any, h: Any) -> Any:
    """S = H + AᵀS(I + GS)⁻¹A, by DOUBLINGS doublings; (2, 2) each."""

    def doubled(_: Any, now: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
        a, g, h = now
        w = inverted(jnp.eye(2, dtype=h.dtype) + g @ h)
        return a @ w @ a, g + a @ w @ g @ a.T, h + a.T @ h @ w @ a

    return jax.lax.fori_loop(0, DOUBLINGS, doubled, (a, g, h))[2]


def inverted(m: Any) -> Any:
    """The inverse of a (2, 2) matrix."""
    adjugate = jnp.stack([jnp.stack([m[1, 1], -m[0, 1]]), jnp.stack([-m[1, 0], m[0, 0]])])
    return adjugate / (m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0])


def regulator(period: float, error: Any, speed: Any, effort: Any) -> Any:
    """(2,) K of a double integrator."""
    a, b = _integrator(period, effort)
    s = riccati(a, jnp.outer(b, b) * effort**2, jnp.diag(jnp.stack([error, speed]) ** -2.0))
    return (b @ s @ a) / (effort**-2.0 + b @ s @ b)


def filtered(period: float, sensor: Any, sensor_speed: Any, unknown: Any) -> Any:
    """(2, 2) L of a double integrator whose state is measured."""
    a, b = _integrator(period, unknown)
    noise = jnp.diag(jnp.stack([sensor, sensor_speed]) ** 2.0)
    p = riccati(a.T, inverted(noise), jnp.outer(b, b) * unknown**2)
    return p @ inverted(p + noise)


def _integrator(period: float, like: Any) -> tuple[Any, Any]:
    """A, B in the type of a number."""
    kind = jnp.result_type(like)
    return jnp.array([[1.0, period], [0.0, 1.0]], kind), jnp.array([0.5 * period * period, period], kind)
