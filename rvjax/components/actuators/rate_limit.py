"""Rate limit of every channel or thruster.

    |u̇| ≤ r u_max,   u(0) = 0:   u(t) = u_k + clip(h(t) − u_k, ±r u_max (t − t_k))

u_max: the true upper limit of the channel or thruster. Exact for a command that is constant during a step.
"""

from __future__ import annotations

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, scalar
from rvjax.components.actuators.interface import Actuator, Limits, Output, at_rest
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels, Scalar, each


class Parameters(Model):
    """Largest rate."""

    rate: Quantity = scalar("1/s", above=0.0, doc="largest rate r, as a share of the upper limit per second")


def act(t: Scalar, u: Channels, memory: Output, limits: Limits, numbers: Numbers) -> Channels:
    """u_k + clip(h − u_k, ±r u_max (t − t_k))."""
    most = limits.upper * (numbers.rate * (t - memory.t))
    return each(lambda h, last, step: last + jnp.clip(h - last, -step, step), u, memory.u, most)


def keep(tick: Tick, u: Channels, memory: Output, limits: Limits, numbers: Numbers) -> Output:
    """The output at the end of the previous step."""
    return Output(tick.t, act(tick.t, u, memory, limits, numbers))


COMPONENT = Component(Parameters, lambda parameters: Actuator(act, at_rest, keep))
