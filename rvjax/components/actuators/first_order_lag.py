"""First-order lag of every channel or thruster.

    T u̇ = h − u,   u(0) = 0

Solved exactly for a command that is constant during a step: u(t) = u_k + (1 − e^{−(t − t_k)/T})(h(t) − u_k).
"""

from __future__ import annotations

from rvjax.campaign import Model, Quantity, scalar
from rvjax.components.actuators.interface import Actuator, Limits, Output, at_rest
from rvjax.components.registry import Component
from rvjax.physics.elementary import exp
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels, Scalar


class Parameters(Model):
    """Time constant."""

    time_constant_s: Quantity = scalar("s", above=0.0, doc="time constant T")


def act(t: Scalar, u: Channels, memory: Output, limits: Limits, numbers: Numbers) -> Channels:
    """u_k + (1 − e^{−(t − t_k)/T})(h − u_k)."""
    del limits
    return memory.u + (u - memory.u) * (1.0 - exp((memory.t - t) / numbers.time_constant_s))


def keep(tick: Tick, u: Channels, memory: Output, limits: Limits, numbers: Numbers) -> Output:
    """The output at the end of the previous step."""
    return Output(tick.t, act(tick.t, u, memory, limits, numbers))


COMPONENT = Component(Parameters, lambda parameters: Actuator(act, at_rest, keep))
