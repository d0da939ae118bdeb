"""The local orbital frame of the target (LVLH), and the frame of its docking port, seen from the target's frame T.

    z = −r/|r| (R-bar, down),   y = −h/|h| (H-bar, against the orbit normal),   x = y × z (V-bar, along the velocity),   h = r × v
    ω_o = h/|r|²,   ω̇_o = −ω_t×ω_o − 2 (rᵀv/|r|²) ω_o            inertial rate of LVLH, and the rate of its components in T

r, v: inertial, resolved in T. W. Fehse, "Automated rendezvous and docking of spacecraft", 2003, §3.1.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp

from rvjax.physics.state import TargetMotion
from rvjax.physics.vectors import Rotation, Scalar, Vector, cross, dot, norm


class Turning(NamedTuple):
    """How a frame about the target's centre turns relative to T: c [rad/s] and ċ [rad/s²], the rate of its components, in T."""

    rate: Vector
    accel: Vector

    def scaled(self, share: Scalar) -> Turning:
        """A frame that turns less."""
        return Turning(self.rate * share, self.accel * share)


def orbit_axes(target: TargetMotion) -> Rotation:
    """The axes x, y, z of LVLH as rows: T → LVLH."""
    h = cross(target.r, target.v)
    z, y = target.r * (-1.0 / norm(target.r)), h * (-1.0 / norm(h))
    return Rotation(cross(y, z), y, z)


def orbit_turning(target: TargetMotion, alpha_t: Vector) -> Turning:
    """LVLH relative to T: c = ω_o − ω_t, ċ = ω̇_o − ω̇_t. alpha_t: ω̇_t, in T [rad/s²]."""
    inverse = 1.0 / dot(target.r, target.r)
    rate = cross(target.r, target.v) * inverse
    swing = cross(rate, target.w) - rate * (2.0 * dot(target.r, target.v) * inverse)
    return Turning(rate - target.w, swing - alpha_t)


def port_axes(n: Vector) -> Rotation:
    """The axes x = n, y, z of the port's frame as rows: T → port. n: docking axis, a unit vector.

    The shortest turn that takes the x axis of T to n takes y and z there; for n = −x half a turn about z.
    y = (−n_y, 1 − k n_y², −k n_y n_z),   z = (−n_z, −k n_y n_z, 1 − k n_z²),   k = 1/(1 + n_x) = (1 − n_x)/(n_y² + n_z²)
    """
    size = jnp.maximum(jnp.abs(n.y), jnp.abs(n.z))
    beside = size > 0.0
    over = 1.0 / jnp.where(beside, size, 1.0)
    b, c = jnp.where(beside, n.y * over, 1.0), jnp.where(beside, n.z * over, 0.0)
    back = n.x < 0.0
    scale = jnp.where(back, (1.0 - n.x) / (b * b + c * c), size * size / (1.0 + jnp.where(back, 0.0, n.x)))
    return Rotation(n, Vector(-n.y, 1.0 - scale * b * b, -(scale * b * c)), Vector(-n.z, -(scale * b * c), 1.0 - scale * c * c))
