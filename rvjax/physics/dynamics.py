"""Relative motion of a pursuer and a cooperative tumbling target, six degrees of freedom (`Motion`, `TargetMotion`).

    target    ṙ_t = v_t − ω_t×r_t
              v̇_t = g(r_t) − ω_t×v_t                         g(r) = −μ r/|r|³
              J_t ω̇_t = −ω_t×J_t ω_t
    relative  ρ̇ = ν − Ω×ρ                                    Ω = ω + R ω_t
              ν̇ = −Ω×ν + n + (f + d_f)/m
              σ̇ = G(σ) ω
              J ω̇ = −Ω×JΩ + J(ω×Rω_t − Rω̇_t) + τ + d_τ
    n = [g(r_p) − R g(r_t)] − R[ω̇_t×δ + ω_t×(ω_t×δ)],   r_p = ρ + R(r_t + δ)

Symbols and frames: `rvjax.physics.state`. v̇_t is the rate of the components of v_t in T; n uses the inertial acceleration of the
docking point. Form of the model: K. Xia, W. Huo, "Adaptive control for spacecraft rendezvous subject to actuator faults and
saturations", ISA Transactions, 2018, reconstructed.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp

from rvjax.physics.constants import MU_EARTH
from rvjax.physics.state import Measurement, Motion, Plant, PointMotion, TargetMotion
from rvjax.physics.vectors import (
    Channels,
    Rotation,
    Scalar,
    Symmetric,
    Vector,
    apply,
    cross,
    dot,
    mrp_rate,
    norm,
    rotate,
    rotation,
)


class Relative(NamedTuple):
    """Quantities that follow from the motion: used by the plant and, with the measured motion, by a controller.

    r: R(σ), T → P. omega_p: Ω, in P [rad/s]. position: r_p from the Earth's centre, in P [m]. accel: n, in P [m/s²].
    alpha: ω×Rω_t − Rω̇_t, in P [rad/s²].
    """

    r: Rotation
    omega_p: Vector
    position: Vector
    accel: Vector
    alpha: Vector


def gravity(r: Vector) -> Vector:
    """g(r) = −μ r/|r|³ [m/s²]; r from the Earth's centre [m]."""
    r2 = dot(r, r)
    return r * (-MU_EARTH / (r2 * jnp.sqrt(r2)))


def differential_gravity(r: Vector, delta: Vector) -> Vector:
    """g(r + Δ) − g(r) = −μ/|r|³ (1+q)^(−3/2) (Δ − F r),  q = (2rᵀΔ + ΔᵀΔ)/|r|²,  F = q(3+3q+q²)/(1+(1+q)^(3/2)).

    Free of cancellation between two numbers of 9 m/s² (R. Battin, "An introduction to the mathematics and methods of
    astrodynamics", 1999, §8.4). r, Δ in the same frame [m].
    """
    r2 = dot(r, r)
    q = (2.0 * dot(r, delta) + dot(delta, delta)) / r2
    root = (1.0 + q) * jnp.sqrt(1.0 + q)
    f = q * (3.0 + q * (3.0 + q)) / (1.0 + root)
    return (delta - r * f) * (-MU_EARTH / (r2 * jnp.sqrt(r2) * root))


def target_alpha(w: Vector, inertia: Symmetric, inertia_inverse: Symmetric) -> Vector:
    """ω̇_t = −J_t⁻¹(ω_t×J_t ω_t), in T [rad/s²]."""
    return -apply(inertia_inverse, cross(w, apply(inertia, w)))


def target_rate(target: TargetMotion, alpha_t: Vector) -> TargetMotion:
    """(ṙ_t, v̇_t, ω̇_t) of the components in T: ṙ_t = v_t − ω_t×r_t, v̇_t = g(r_t) − ω_t×v_t."""
    return TargetMotion(r=target.v - cross(target.w, target.r), v=gravity(target.r) - cross(target.w, target.v), w=alpha_t)


def relative(motion: Motion, target: TargetMotion, alpha_t: Vector, port: Vector) -> Relative:
    """R, Ω, r_p, n and ω×Rω_t − Rω̇_t (`Relative`) of a motion; alpha_t: ω̇_t, port: δ, both in T."""
    r = rotation(motion.sigma)
    w = rotate(r, target.w)
    centre = rotate(r, target.r)
    delta = motion.rho + rotate(r, port)
    swing = cross(alpha_t, port) + cross(target.w, cross(target.w, port))
    return Relative(
        r=r,
        omega_p=motion.omega + w,
        position=centre + delta,
        accel=differential_gravity(centre, delta) - rotate(r, swing),
        alpha=cross(motion.omega, w) - rotate(r, alpha_t),
    )


def measured_relative(measurement: Measurement, motion: Motion | None = None) -> Relative:
    """`relative` of a measured motion, or of the controller's estimate of it. The reference point may move in T:

    n = [g(r_p) − R g(r_t)] − R[ω̇_t×p + ω_t×(ω_t×p) + 2ω_t×ṗ + p̈]
    """
    seen = measurement.motion if motion is None else motion
    known = relative(seen, measurement.target, measurement.alpha_t, measurement.port)
    if not isinstance(measurement.moving, PointMotion):
        return known
    velocity, accel = measurement.moving
    return known._replace(accel=known.accel - rotate(known.r, cross(measurement.target.w, velocity) * 2.0 + accel))


def motion_rate(motion: Motion, known: Relative, plant: Plant, wrench: Channels) -> Motion:
    """(ρ̇, ν̇, σ̇, ω̇) under the total wrench (f + d_f, τ + d_τ) on the pursuer, in P [N, N·m]."""
    gyro = cross(known.omega_p, apply(plant.inertia, known.omega_p))
    return Motion(
        rho=motion.nu - cross(known.omega_p, motion.rho),
        nu=known.accel - cross(known.omega_p, motion.nu) + wrench.force * (1.0 / plant.mass),
        sigma=mrp_rate(motion.sigma, motion.omega),
        omega=known.alpha + apply(plant.inertia_inverse, wrench.torque - gyro),
    )


def gravity_gradient(position: Vector, inertia: Symmetric) -> Vector:
    """τ = 3μ/|r|⁵ r×Jr [N·m]; r from the Earth's centre to the body [m], in the body's frame."""
    distance: Scalar = norm(position)
    unit = position / distance
    return cross(unit, apply(inertia, unit)) * (3.0 * MU_EARTH / (distance * distance * distance))
