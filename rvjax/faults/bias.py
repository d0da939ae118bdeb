"""Bias of an actuator channel, as a step.

    u = h                     t < t_f
    u = h + s u⁺              t ≥ t_f

s: bias as a share of the channel's true upper limit u⁺, of either sign. The usual additive actuator fault (Xia, Huo, 2018).
"""

from __future__ import annotations

import jax.numpy as jnp

from rvjax.algebra import Channels, Scalar, each
from rvjax.family import Component
from rvjax.faults.interface import FaultParameters
from rvjax.spec import Quantity, channels
from rvjax.state import Numbers, Plant


class Parameters(FaultParameters):
    """Size of the bias, channel by channel."""

    share: Quantity = channels("1", at_least=-1.0, at_most=1.0, doc="bias s as a share of the channel's upper limit")


def fault(t: Scalar, wrench: Channels, plant: Plant, numbers: Numbers) -> Channels:
    """u = h + s u⁺ from the onset on, h before."""

    def biased(h: Scalar, start: Scalar, share: Scalar, upper: Scalar) -> Scalar:
        return jnp.where(t >= start, h + share * upper, h)

    return each(biased, wrench, numbers.onset_s, numbers.share, plant.upper)


COMPONENT = Component(Parameters, lambda parameters: fault)
