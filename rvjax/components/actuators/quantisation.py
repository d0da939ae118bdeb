"""Quantisation of every channel or thruster: the nearest multiple of a step.

    u = q u_max round(h/(q u_max))

u_max: the true upper limit of the channel or thruster; halves go to the even multiple.
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, scalar
from rvjax.components.actuators.interface import Actuator, Limits
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels, Scalar, each


class Parameters(Model):
    """Size of a step."""

    step: Quantity = scalar("1", above=0.0, at_most=1.0, doc="step q as a share of the upper limit")


def act(t: Scalar, u: Channels, memory: Any, limits: Limits, numbers: Numbers) -> Channels:
    """The nearest multiple."""
    del t, memory
    return each(lambda h, step: step * jnp.round(h / step), u, limits.upper * numbers.step)


COMPONENT = Component(Parameters, lambda parameters: Actuator(act))
