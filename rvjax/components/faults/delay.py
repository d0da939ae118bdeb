"""Delay of an actuator channel by whole steps.

    u(t) = h(t_{k−n})       while the fault acts, for t in step k

What is asked for at the beginning of a step comes n steps later and stands for one step; before the flight nothing was asked for.
"""

from __future__ import annotations

from functools import partial

import jax.numpy as jnp

from rvjax.campaign import count
from rvjax.components.faults.interface import Fault, FaultParameters, acts
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels, Scalar, each

MOST_STEPS = 64
"""Every step of delay is six more numbers that each sample carries."""


class Parameters(FaultParameters):
    """How long the delay is."""

    steps: int = count(at_least=1, at_most=MOST_STEPS, doc="delay n in steps of the integration")


Past = tuple[Channels, ...]
"""h at the beginnings of this step and of the n steps before it, the latest first."""


def start(steps: int, u: Channels, numbers: Numbers) -> Past:
    """Before the first step the actuators are idle."""
    del numbers
    return (u,) * (steps + 1)


def keep(tick: Tick, u: Channels, memory: Past, numbers: Numbers) -> Past:
    """The beginning of this step in front, the oldest forgotten."""
    del tick, numbers
    return (u, *memory[:-1])


def act(t: Scalar, u: Channels, memory: Past, upper: Channels, numbers: Numbers) -> Channels:
    """The oldest while the fault acts."""
    del upper
    return each(jnp.where, acts(t, numbers), memory[-1], u)


def build(parameters: Parameters) -> Fault:
    """With so many steps."""
    return Fault(act, partial(start, parameters.steps), keep)


COMPONENT = Component(Parameters, build)
