"""Drift of an actuator channel: a bias that grows.

    u = h + u⁺ sign(r) min(|r| (t − t_f), s_max)       while the fault acts

r: rate as a share of the channel's true upper limit u⁺ per second, positive or negative; s_max: largest bias as a share of u⁺.
"""

from __future__ import annotations

import jax.numpy as jnp

from rvjax.campaign import Quantity, channels
from rvjax.components.faults.interface import FaultParameters, fault
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels, Scalar, each


class Parameters(FaultParameters):
    """Growth and size of the bias, per channel."""

    growth: Quantity = channels("1/s", doc="rate r of the bias, as a share of the channel's upper limit")
    most: Quantity = channels("1", default=1.0, at_least=0.0, doc="largest bias s_max as a share of the channel's upper limit")


def failed(u: Channels, since: Channels, memory: tuple[()], upper: Channels, numbers: Numbers) -> Channels:
    """h + u⁺ clip(r (t − t_f), −s_max, s_max)."""
    del memory

    def drifted(h: Scalar, s: Scalar, limit: Scalar, growth: Scalar, most: Scalar) -> Scalar:
        return h + limit * jnp.clip(growth * s, -most, most)

    return each(drifted, u, since, upper, numbers.growth, numbers.most)


COMPONENT = Component(Parameters, lambda parameters: fault(failed), neutral=({"growth": 0.0}, {"most": 0.0}))
