"""Slow actuator channel: a first-order lag.

    τ u̇ = h − u,  u(t_f) = h(t_f)       while the fault acts

Solved exactly for a command that is constant during a step: u(t) = u_k + (1 − e^{−(t − t_k)/τ})(h(t) − u_k). The response to a
constant command is an exact exponential for any step.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp

from rvjax.campaign import Quantity, channels
from rvjax.components.faults.interface import Fault, FaultParameters, acts
from rvjax.components.registry import Component
from rvjax.physics.elementary import exp
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels, Scalar, each


class Parameters(FaultParameters):
    """Time constant, per channel."""

    time_constant_s: Quantity = channels("s", above=0.0, doc="time constant τ")


class Output(NamedTuple):
    """u_k [N, N·m] at the beginning t_k [s] of the step."""

    t: Scalar
    u: Channels


def start(u: Channels, numbers: Numbers) -> Output:
    """Idle actuators before the first step."""
    del numbers
    return Output(u.parts()[0], u)


def act(t: Scalar, u: Channels, memory: Output, upper: Channels, numbers: Numbers) -> Channels:
    """u_k + (1 − e^{−(t − t_k)/τ})(h − u_k) while the fault acts."""
    del upper

    def lagging(on: Scalar, h: Scalar, last: Scalar, tau: Scalar) -> Scalar:
        return jnp.where(on, last + (1.0 - exp((memory.t - t) / tau)) * (h - last), h)

    return each(lagging, acts(t, numbers), u, memory.u, numbers.time_constant_s)


def keep(tick: Tick, u: Channels, memory: Output, numbers: Numbers) -> Output:
    """The output at the end of the previous step."""
    return Output(tick.t, act(tick.t, u, memory, u, numbers))


COMPONENT = Component(Parameters, lambda parameters: Fault(act, start, keep))
