"""A vibrating mode of an appendage, as a mass on springs at a point of the pursuer: one frequency per axis.

    ẏ = w,   ẇ = −ω² y − 2ζω w − (a + α×r + Ω×(Ω×r))_axis          y: displacement [m], on each axis of P
    F = m_a (ω² y + 2ζω w),   M = r × F                            on the pursuer

m_a: modal mass, ω, ζ: frequency and damping with the pursuer held; r: place of the appendage. The displacement is small against
r: terms of y α, y Ω² and w Ω are left out. An axis with the frequency 0 is rigid: its modal mass then belongs into
pursuer.mass_kg. m_a is not part of pursuer.mass_kg. Several modes are several entries.

r is from the pursuer's centre of mass of the instant, without m_a. Where pursuer.propellant moves that by c − c₀ in the body, the
appendage moves with it: the torque differs by (c − c₀) × F from that of an appendage that stays in its place of t = 0.

P. W. Likins, "Dynamics and control of flexible space vehicles", NASA JPL TR 32-1329, 1970 (hybrid coordinates).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, scalar, vector
from rvjax.columns import Column
from rvjax.components.effects.interface import Body, Effect, turned
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels, Vector, cross, each


class Parameters(Model):
    """The mode. At t = 0 it is at rest."""

    modal_mass_kg: Quantity = scalar("kg", above=0.0, doc="modal mass m_a, besides pursuer.mass_kg")
    frequency_rad_s: Quantity = vector("rad/s", key="frequency_Hz", at_least=0.0, doc="frequency ω on each axis; 0: rigid")
    damping: Quantity = scalar("1", default=0.005, at_least=0.0, below=1.0, doc="damping ratio ζ")
    place_m: Quantity = vector("m", default=0.0, doc="place r of the appendage, from the centre of mass, in the pursuer's frame")


class Mode(NamedTuple):
    """y [m], w [m/s]."""

    displacement: Vector
    speed: Vector


def start(numbers: Numbers) -> Mode:
    """At rest."""
    return Mode(numbers.frequency_rad_s * 0.0, numbers.frequency_rad_s * 0.0)


def pull(x: Mode, numbers: Numbers) -> Vector:
    """ω² y + 2ζω w [m/s²]."""
    return each(lambda y, v, w: w * w * y + 2.0 * numbers.damping * w * v, x.displacement, x.speed, numbers.frequency_rad_s)


def wrench(body: Body, x: Mode, numbers: Numbers) -> Channels:
    """F, M."""
    del body
    force = pull(x, numbers) * numbers.modal_mass_kg
    return Channels(force, cross(numbers.place_m, force))


def rate(body: Body, accel: Vector, alpha: Vector, x: Mode, numbers: Numbers) -> Mode:
    """ẏ, ẇ; none on a rigid axis."""
    second = -(accel + turned(body.rate, alpha, numbers.place_m)) - pull(x, numbers)
    moves = each(lambda w, a: jnp.where(w > 0.0, a, 0.0), numbers.frequency_rad_s, second)
    return Mode(x.speed, moves)


def record(body: Body, x: Mode, numbers: Numbers) -> Mapping[str, Any]:
    """The displacement."""
    del body, numbers
    return {"displacement": x.displacement}


SIGNALS = {"displacement": Column("displacement", "m", "displacement of the appendage, in P")}

COMPONENT = Component(Parameters, lambda parameters: Effect(start, wrench, rate, record, SIGNALS))
