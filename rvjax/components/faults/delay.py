"""Delay of an actuator channel by whole steps.

    u(t) = h(t_{k−n})       while the fault acts, for t in step k

The command at the beginning of a step takes effect n steps later and is held for a step (`rvjax.physics.delay_line`). Before the
flight the command is zero.
"""

from __future__ import annotations

from functools import partial

import jax.numpy as jnp

from rvjax.campaign import count
from rvjax.components.faults.interface import Fault, FaultParameters, acts
from rvjax.components.registry import Component
from rvjax.physics.delay_line import MOST_STEPS, delayed, filled, pushed
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels, Scalar, each

Line = tuple[Channels, ...]


class Parameters(FaultParameters):
    """Length of the delay."""

    steps: int = count(at_least=1, at_most=MOST_STEPS, doc="delay n in integration steps")


def start(steps: int, u: Channels, numbers: Numbers) -> Line:
    """Idle actuators before the first step."""
    del numbers
    return filled(steps, u)


def keep(tick: Tick, u: Channels, memory: Line, numbers: Numbers) -> Line:
    """Adds the command at the beginning of this step."""
    del tick, numbers
    return pushed(memory, u)


def act(t: Scalar, u: Channels, memory: Line, upper: Channels, numbers: Numbers) -> Channels:
    """The delayed command while the fault acts, else the command."""
    del upper
    return each(jnp.where, acts(t, numbers), delayed(memory), u)


def build(parameters: Parameters) -> Fault:
    """A delay of n steps."""
    return Fault(act, partial(start, parameters.steps), keep)


COMPONENT = Component(Parameters, build)
