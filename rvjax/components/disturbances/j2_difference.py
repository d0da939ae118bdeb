"""Differential J2: J2 acceleration of the pursuer minus that of the target. The plant integrates the target's motion without J2.

    d_f = m [a(r + Δ) − a(r)],   a(r) = −3/2 J₂ μ R_E²/|r|⁴ [(1 − 5s²) r̂ + 2s k],   s = r̂ᵀk,   r̂ = r/|r|
    k = cos i ĥ + sin i (sin u r̂ + cos u ĥ×r̂),   ĥ = r×v/|r×v|,   u̇ = |r×v|/|r|²

r, v: of the target; Δ: from the target to the pursuer; k: the Earth's pole, from the inclination i and the argument of latitude
u, because the plant has no pole. J2 turns the orbit by 1e-6 rad/s; this model keeps i and ĥ constant. u is integrated with its
first two derivatives; the error is about e|u̇|³h²t/3 after the time t: 3e-11 rad for e = 0.1, h = 0.05 s and t = 300 s. No torque:
that of J2 is a few thousandths of the gravity gradient.

With n = r̂, δ = Δ/|r|, d = δᵀk, q = 2nᵀδ + δᵀδ, p = √(1+q) = |r+Δ|/|r|, φ_j = p^{−j} − 1, the difference is

    a(r+Δ) − a(r) = −3/2 J₂ μ R_E²/|r|⁴ { p⁻⁵δ + φ₅n − 5[(s+d)²p⁻⁷δ + (d(2s+d)p⁻⁷ + s²φ₇)n] + 2(p⁻⁵d + φ₅s)k }

which avoids the cancellation of two numbers of 1e-2 m/s² that differ by 1e-7 at 30 m. D. Vallado, "Fundamentals of astrodynamics
and applications", 2013, §8.7.1; J₂, R_E: EGM2008.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, scalar
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.registry import Component
from rvjax.physics.constants import MU_EARTH
from rvjax.physics.dynamics import Relative
from rvjax.physics.elementary import cos, sin
from rvjax.physics.state import Numbers, Plant, State, TargetMotion, Tick
from rvjax.physics.vectors import Channels, Scalar, Vector, cross, dot, norm, rotate

J2 = 1.0826355e-3
EARTH_RADIUS_M = 6378136.3


class Parameters(Model):
    """Inclination and argument of latitude of the orbit."""

    inclination_rad: Quantity = scalar(
        "rad", key="inclination_deg", at_least=0.0, at_most=180.0, doc="inclination i of the orbit"
    )
    latitude_rad: Quantity = scalar(
        "rad",
        key="latitude_deg",
        default=0.0,
        doc="argument of latitude u at t = 0, from the ascending node to the target",
    )


class Phase(NamedTuple):
    """u [rad], u̇ [rad/s] and half of ü [rad/s²] at the beginning t [s] of the step."""

    t: Scalar
    u: Scalar
    rate: Scalar
    half: Scalar


def start(numbers: Numbers) -> Phase:
    """The initial u; the first step computes its rate."""
    zero = numbers.latitude_rad * 0.0
    return Phase(zero, numbers.latitude_rad, zero, zero)


def keep(tick: Tick, y: State, memory: Phase, numbers: Numbers) -> Phase:
    """u̇ = |r×v|/|r|², ü = −2u̇ rᵀv/|r|²."""
    del numbers
    r, v = y.target.r, y.target.v
    r2 = dot(r, r)
    rate = norm(cross(r, v)) / r2
    return Phase(tick.t, latitude(tick.t, memory), rate, -rate * dot(r, v) / r2)


def latitude(t: Scalar, memory: Phase) -> Scalar:
    """u(t) = u + u̇ (t − t_k) + ü (t − t_k)²/2 [rad]."""
    since = t - memory.t
    return memory.u + (memory.rate + memory.half * since) * since


def pole(target: TargetMotion, u: Scalar, inclination: Scalar) -> Vector:
    """k = cos i ĥ + sin i (sin u r̂ + cos u ĥ×r̂), in T."""
    momentum = cross(target.r, target.v)
    normal, out = momentum / norm(momentum), target.r / norm(target.r)
    return normal * cos(inclination) + (out * sin(u) + cross(normal, out) * cos(u)) * sin(inclination)


def difference(r: Vector, delta: Vector, k: Vector) -> Vector:
    """a(r + Δ) − a(r) of J2 [m/s²]; r, Δ [m] and the pole k in the same frame."""
    distance = norm(r)
    n, off = r / distance, delta / distance
    s, d = dot(n, k), dot(off, k)
    q = 2.0 * dot(n, off) + dot(off, off)
    p = jnp.sqrt(1.0 + q)
    rise = q / (1.0 + p)  # p − 1
    p2 = p * p
    p5 = p2 * p2 * p
    sum5 = 1.0 + p + p2 + p2 * p + p2 * p2
    fifth, seventh = 1.0 / p5, 1.0 / (p5 * p2)
    phi5, phi7 = -rise * sum5 * fifth, -rise * (sum5 + p5 + p5 * p) * seventh
    straight = off * fifth + n * phi5
    bent = off * ((s + d) * (s + d) * seventh) + n * (d * (2.0 * s + d) * seventh + s * s * phi7)
    scale = -1.5 * J2 * MU_EARTH * (EARTH_RADIUS_M / distance) * (EARTH_RADIUS_M / distance) / (distance * distance)
    return (straight - bent * 5.0 + k * (2.0 * (d * fifth + s * phi5))) * scale


def push(t: Scalar, y: State, known: Relative, plant: Plant, memory: Phase, numbers: Numbers) -> Channels:
    """(m [a(r + Δ) − a(r)], 0)."""
    k = pole(y.target, latitude(t, memory), numbers.inclination_rad)
    delta = y.motion.rho + rotate(known.r, plant.port)
    pull = difference(rotate(known.r, y.target.r), delta, rotate(known.r, k))
    return Channels(pull * plant.mass, delta * 0.0)


COMPONENT = Component(Parameters, lambda parameters: Disturbance(push, start, keep))
