"""Free motion of two bodies about the Earth: the pursuer relative to the target, without thrust or disturbances.

    r̈ = g(r),   Δ̈ = g(r + Δ) − g(r)                        g(r) = −μ r/|r|³
    Δ = Rᵀρ + δ,   Δ̇ = Rᵀν + ω_t×δ                         from the state of a flight

r: target's centre of mass from the Earth's centre; Δ: pursuer's centre of mass from the target's. Rates are inertial. All vectors
are resolved in axes that do not turn: the axes that T has at the instant where the free motion begins.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import jax

from rvjax.physics.dynamics import differential_gravity, gravity
from rvjax.physics.state import Motion, TargetMotion
from rvjax.physics.vectors import Scalar, Vector, cross, rotate_back, rotation

Y = TypeVar("Y")


class FreeMotion(NamedTuple):
    """Place and velocity of the target, r [m] and v [m/s], and of the pursuer relative to it, Δ [m] and Δ̇ [m/s]."""

    r: Vector
    v: Vector
    delta: Vector
    speed: Vector


def free_motion(motion: Motion, target: TargetMotion, port: Vector) -> FreeMotion:
    """r, v, Δ = Rᵀρ + δ, Δ̇ = Rᵀν + ω_t×δ, in T. port: δ."""
    r = rotation(motion.sigma)
    delta, speed = rotate_back(r, motion.rho) + port, rotate_back(r, motion.nu) + cross(target.w, port)
    return FreeMotion(target.r, target.v, delta, speed)


def free_rate(y: FreeMotion) -> FreeMotion:
    """(v, g(r), Δ̇, g(r + Δ) − g(r))."""
    return FreeMotion(y.v, gravity(y.r), y.speed, differential_gravity(y.r, y.delta))


def rk4(rate: Callable[[Y], Y], y: Y, h: Scalar) -> Y:
    """y(t+h) for ẏ = rate(y), by the classical Runge–Kutta method of order 4. y: any tree of numbers."""

    def along(slope: Y, h: Scalar) -> Y:
        return jax.tree.map(lambda a, k: a + h * k, y, slope)

    k1 = rate(y)
    k2 = rate(along(k1, 0.5 * h))
    k3 = rate(along(k2, 0.5 * h))
    k4 = rate(along(k3, h))
    return jax.tree.map(lambda a, p, q, r, s: a + (h / 6.0) * (p + 2.0 * (q + r) + s), y, k1, k2, k3, k4)
