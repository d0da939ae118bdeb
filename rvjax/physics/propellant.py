"""Propellant: what the actuators burn, and the pursuer that is left.

    ṁ_c = F/(I_sp g₀)                        m_c: consumed mass, an integrated state;  g₀ = 9.80665 m/s²
    F = Σ fᵢ                                 with thrusters, fᵢ: thrusts behind the faults
    F = Σ |f_axis| + Σ |τ_axis|/l            with six channels: a pair of thrusters on each axis, l: arm of those of the torques;
                                             without l torques burn nothing, as of wheels
    q = min(m_c, m_p)                        m_p: propellant at t = 0
    m = m₀ − q
    c = c₀ − (q/m)(r − c₀)
    J_C = J₀ − (q m₀/m)(|r − c₀|² I − (r − c₀)(r − c₀)ᵀ)

m₀, c₀, J₀: of the pursuer at t = 0 with all its propellant, J about the centre of mass; r: tank; c₀ and r are from the reference
point, in P. The propellant is a point mass at the tank. The equations are Steiner's theorem for the body at t = 0 without a point
mass q.

Where m_c ≥ m_p at the start of a step, the actuators that burn propellant give nothing in that step and later: up to a step of
thrust is fired after the last of the propellant. F = 0 then; torques without an arm go on.

The motion (`rvjax.physics.dynamics`) is that of a rigid body with the m, c and J_C of the instant. Left out:

    jet damping               the momentum of the propellant on its way from tank to thruster, 2 ṁ_c Ω×l_t and its torque, and
                              J̇Ω: of the size 2|Ω| l_t/(I_sp g₀) of the thrust, 1e-5 with 0.01 rad/s, a path l_t of 1 m and 200 s
    the way of c in the body  ρ and ν are of the centre of mass of the instant, and are not moved with it: |c − c₀| in position
    sloshing                  is an effect of its own (`slosh-pendulum`), with a mass besides pursuer.mass_kg that is not burnt
    places of effects         are from the centre of mass of the instant, and move with it in the body by c − c₀ = −(q/m)(r − c₀)

K. E. Tsiolkovsky: without gravity and with thrusters in one direction Δv = I_sp g₀ ln(m₀/m).
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp

from rvjax.physics.state import Plant, Tank
from rvjax.physics.vectors import Channels, Scalar, Symmetric, Thrusts, Vector, each, inverse, total

G0 = 9.80665
"""Standard gravity g₀ [m/s²], by which a specific impulse in seconds is a speed of the exhaust."""


class Propellant(NamedTuple):
    """Numbers: m_p [kg], which is part of m₀; I_sp [s]; r, in P [m]; l [m], empty without."""

    mass: Scalar
    specific_impulse: Scalar
    tank: Vector
    arm: Scalar | tuple[()] = ()


def thrust_sum(applied: Channels, thrusts: Thrusts | tuple[()]) -> Scalar:
    """Σ fᵢ of the thrusters, or Σ |f_axis| of the channels [N]: opposing thrusts add up."""
    return total(thrusts) if isinstance(thrusts, Thrusts) else total(each(jnp.abs, applied.force))


def flow(propellant: Propellant, applied: Channels, thrusts: Thrusts | tuple[()]) -> Scalar:
    """ṁ_c [kg/s] of the applied wrench, or of the thrusts that make it."""
    burning = thrust_sum(applied, thrusts)
    if not isinstance(propellant.arm, tuple):
        burning = burning + total(each(jnp.abs, applied.torque)) / propellant.arm
    return burning / (propellant.specific_impulse * G0)


def feeds(propellant: Propellant, consumed: Scalar) -> Scalar:
    """1 while there is propellant, else 0."""
    return jnp.where(consumed < propellant.mass, 1.0, 0.0)


def supplied(
    propellant: Propellant, fed: Scalar, applied: Channels, thrusts: Thrusts | tuple[()]
) -> tuple[Channels, Thrusts | tuple[()]]:
    """(applied wrench, thrusts) where fed is 1; where it is 0 the actuators that burn propellant give nothing."""
    if isinstance(thrusts, Thrusts):
        return applied * fed, thrusts * fed
    torque = applied.torque if isinstance(propellant.arm, tuple) else applied.torque * fed
    return Channels(applied.force * fed, torque), thrusts


def level(propellant: Propellant, consumed: Scalar) -> Tank:
    """q and m_p − q [kg]."""
    used = jnp.minimum(consumed, propellant.mass)
    return Tank(used, propellant.mass - used)


def lighter(plant: Plant, propellant: Propellant, used: Scalar) -> Plant:
    """The plant at t = 0 without q = used of its propellant: m, c, J_C and its inverse."""
    mass = plant.mass - used
    d = propellant.tank - plant.centre
    moved = used * plant.mass / mass
    inertia = plant.inertia - _of_a_point(d) * moved
    return plant._replace(mass=mass, inertia=inertia, inertia_inverse=inverse(inertia), centre=plant.centre - d * (used / mass))


def _of_a_point(d: Vector) -> Symmetric:
    """|d|² I − d dᵀ: the inertia of 1 kg at d."""
    x, y, z = d.parts()
    return Symmetric(y * y + z * z, x * x + z * z, x * x + y * y, -(y * z), -(x * z), -(x * y))
