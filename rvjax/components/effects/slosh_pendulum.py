"""Sloshing propellant as a spherical pendulum: a mass on a rigid rod that turns about a point fixed in the pursuer.

    q = p + l e,  |e| = 1                       place of the mass m_s, from the pursuer's centre of mass, in P
    m_s a_s = −S e − c l ė                      S: tension of the rod, c: damping
    a_s = a + α×q + Ω×(Ω×q) + 2 l Ω×ė + l dė/dt
    F = S e + c l ė,   M = q × F                on the pursuer

a and the angular acceleration α follow from the applied wrench and from F, so S has both sides in it:

    S = m_s [l|ė|² − e·(a_0 + α_0×q + Ω×(Ω×q) + 2 l Ω×ė)] / (1 + m_s [1/m + (q×e)·J⁻¹(q×e)])

a_0, α_0: acceleration under all other wrenches and the damping force. The part of ė along e, which rounding brings, is left out.
m_s is not part of pursuer.mass_kg.

p is from the pursuer's centre of mass of the instant, without m_s. Where pursuer.propellant moves that by c − c₀ in the body, the
pivot moves with it: the torque differs by (c − c₀) × F from that of a pivot that stays in its place of t = 0. m_s is not burnt.

H. N. Abramson (ed.), "The dynamic behavior of liquids in moving containers", NASA SP-106, 1966, ch. 6 (equivalent pendulum).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from rvjax.campaign import Model, Quantity, scalar, vector
from rvjax.columns import Column
from rvjax.components.effects.interface import Body, Effect, turned
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels, Scalar, Vector, apply, cross, dot, norm


class Parameters(Model):
    """The pendulum. At t = 0 it is at rest in the pursuer."""

    slosh_mass_kg: Quantity = scalar("kg", above=0.0, doc="mass m_s of the pendulum, besides pursuer.mass_kg")
    pivot_m: Quantity = vector("m", default=0.0, doc="pivot p, from the centre of mass, in the pursuer's frame")
    rod_m: Quantity = vector("m", doc="rod at t = 0, from the pivot to the mass, in the pursuer's frame")
    damping: Quantity = scalar("N·s/m", default=0.0, at_least=0.0, doc="damping c of the relative motion")


class Pendulum(NamedTuple):
    """e, and ė [1/s]."""

    direction: Vector
    rate: Vector


def start(numbers: Numbers) -> Pendulum:
    """At rest in its direction."""
    e = numbers.rod_m
    return Pendulum(e / norm(e), e * 0.0)


def unit(x: Pendulum) -> Pendulum:
    """e with length 1, and the part of ė that is normal to it."""
    e = x.direction / norm(x.direction)
    return Pendulum(e, x.rate - e * dot(e, x.rate))


def place(x: Pendulum, numbers: Numbers) -> Vector:
    """q."""
    return numbers.pivot_m + x.direction * norm(numbers.rod_m)


def tension(body: Body, x: Pendulum, numbers: Numbers) -> Scalar:
    """S [N]."""
    m, l = numbers.slosh_mass_kg, norm(numbers.rod_m)  # noqa: E741
    q, e = place(x, numbers), x.direction
    drag = x.rate * (numbers.damping * l)
    accel = body.free_accel + drag / body.mass
    alpha = body.free_alpha + apply(body.inertia_inverse, cross(q, drag))
    along = dot(e, accel + turned(body.rate, alpha, q) + cross(body.rate, x.rate) * (2.0 * l)) - l * dot(x.rate, x.rate)
    lever = cross(q, e)
    return -m * along / (1.0 + m * (1.0 / body.mass + dot(lever, apply(body.inertia_inverse, lever))))


def wrench(body: Body, x: Pendulum, numbers: Numbers) -> Channels:
    """F, M."""
    x = unit(x)
    force = x.direction * tension(body, x, numbers) + x.rate * (numbers.damping * norm(numbers.rod_m))
    return Channels(force, cross(place(x, numbers), force))


def rate(body: Body, accel: Vector, alpha: Vector, x: Pendulum, numbers: Numbers) -> Pendulum:
    """ė, and its rate from m_s a_s = −F."""
    x = unit(x)
    force = wrench(body, x, numbers).force
    pivot = accel + turned(body.rate, alpha, place(x, numbers)) + cross(body.rate, x.rate) * (2.0 * norm(numbers.rod_m))
    second = (force / -numbers.slosh_mass_kg - pivot) / norm(numbers.rod_m)
    return Pendulum(x.rate, second)


def record(body: Body, x: Pendulum, numbers: Numbers) -> Mapping[str, Any]:
    """Direction, and tension."""
    x = unit(x)
    return {"direction": x.direction, "tension": tension(body, x, numbers)}


SIGNALS = {
    "direction": Column("direction", "1", "direction of the rod, in P"),
    "tension": Column("tension", "N", "tension of the rod"),
}

COMPONENT = Component(Parameters, lambda parameters: Effect(start, wrench, rate, record, SIGNALS, implicit=True))
