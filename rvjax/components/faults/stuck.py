"""Actuator channel stuck at a value, or at its last value.

    u = s u⁺            with a share s of the channel's true upper limit u⁺
    u = h(t_f)          without a share: the output at the beginning of the step in which the fault begins

while the fault acts. An intermittent fault sticks at a new value each time. The lock-in-place fault (J. Boskovic, R. Mehra,
"Multiple-model adaptive flight control scheme for accommodation of actuator failures", J. Guidance, Control, and Dynamics, 2002).
"""

from __future__ import annotations

import jax.numpy as jnp

from rvjax.campaign import Quantity, channels
from rvjax.components.faults.interface import Fault, FaultParameters, acts, fault
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels, Scalar, each


class Parameters(FaultParameters):
    """Stuck value, per channel."""

    share: Quantity | None = channels(
        "1",
        default=None,
        at_least=-1.0,
        at_most=1.0,
        doc="value s as a share of the channel's upper limit; null: the last value",
    )


def failed(u: Channels, since: Channels, memory: tuple[()], upper: Channels, numbers: Numbers) -> Channels:
    """s u⁺."""
    del u, since, memory
    return numbers.share * upper


def start(u: Channels, numbers: Numbers) -> Channels:
    """Idle actuators before the first step."""
    del numbers
    return u


def keep(tick: Tick, u: Channels, memory: Channels, numbers: Numbers) -> Channels:
    """The last input while the fault did not act."""
    return each(jnp.where, acts(tick.t, numbers), memory, u)


def act(t: Scalar, u: Channels, memory: Channels, upper: Channels, numbers: Numbers) -> Channels:
    """The memory while the fault acts."""
    del upper
    return each(jnp.where, acts(t, numbers), memory, u)


def build(parameters: Parameters) -> Fault:
    """Stuck at a value if there is a share, else at the last value."""
    return fault(failed) if parameters.share is not None else Fault(act, start, keep)


COMPONENT = Component(Parameters, build)
