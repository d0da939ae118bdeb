"""Pulse-width modulation of every channel or thruster: full on for a part of each period, else off.

    T_on = T |h_j|/u_max,   0 where it is below the shortest pulse, T where the pause would be shorter than the shortest pulse
    u = sign(h_j) u_max     for t_j ≤ t < t_j + T_on,   0 for the rest of the period

h_j: command at the beginning t_j of period j; u_max: true limit on the side of its sign. A pulse that begins or ends within a
step of the integration acts during the whole step with the same impulse: u_max times its share of the step.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, scalar
from rvjax.components.actuators.interface import Actuator, Limits
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels, Scalar, each

ROUNDING = 1e-6
"""Share of a period by which an instant may be early, by rounding."""


class Parameters(Model):
    """Period and shortest pulse."""

    period_s: Quantity = scalar("s", above=0.0, doc="period T")
    shortest_s: Quantity = scalar("s", default=0.0, at_least=0.0, doc="shortest pulse, and shortest pause")


class Pulse(NamedTuple):
    """period: its number j, −1 before the first; on: T_on with the sign of the command [s]; share: of this step that is on, with
    the sign."""

    period: Scalar
    on: Channels
    share: Channels


def start(u: Channels, numbers: Numbers) -> Pulse:
    """Before the first period."""
    return Pulse(u.parts()[0] - 1.0, u, u)


def keep(tick: Tick, u: Channels, memory: Pulse, limits: Limits, numbers: Numbers) -> Pulse:
    """The pulse of the period that the step begins in, and its share of the step."""
    period, shortest = numbers.period_s, numbers.shortest_s
    j = jnp.floor(tick.t / period + ROUNDING)
    new = j > memory.period

    def pulse(h: Scalar, upper: Scalar, lower: Scalar, before: Scalar) -> Scalar:
        side = jnp.where(h >= 0.0, upper, lower)
        on = period * jnp.minimum(jnp.abs(h) / jnp.where(side > 0.0, side, 1.0), 1.0)
        on = jnp.where(on < shortest, 0.0, jnp.where(period - on < shortest, period, on))
        return jnp.where(new, jnp.sign(h) * on, before)

    on = each(pulse, u, limits.upper, limits.lower, memory.on)
    since = tick.t - j * period
    share = each(lambda x: jnp.sign(x) * jnp.clip((jnp.abs(x) - since) / tick.h, 0.0, 1.0), on)
    return Pulse(jnp.where(new, j, memory.period), on, share)


def act(t: Scalar, u: Channels, memory: Pulse, limits: Limits, numbers: Numbers) -> Channels:
    """u_max times the share of the step."""
    del t, u, numbers
    return each(lambda x, upper, lower: x * jnp.where(x >= 0.0, upper, lower), memory.share, limits.upper, limits.lower)


COMPONENT = Component(Parameters, lambda parameters: Actuator(act, start, keep))
