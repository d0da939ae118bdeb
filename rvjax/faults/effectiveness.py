"""Loss of effectiveness of an actuator channel, as a step.

    u = h                     t < t_f
    u = e h,  0 ≤ e ≤ 1       t ≥ t_f

e = 1: sound; e = 0: lost. The usual multiplicative actuator fault (Xia, Huo, 2018).
"""

from __future__ import annotations

import jax.numpy as jnp

from rvjax.algebra import Channels, Scalar, each
from rvjax.family import Component
from rvjax.faults.interface import FaultParameters
from rvjax.spec import Quantity, channels
from rvjax.state import Numbers, Plant


class Parameters(FaultParameters):
    """Remaining effectiveness, channel by channel."""

    remaining: Quantity = channels("1", at_least=0.0, at_most=1.0, doc="effectiveness e after the onset")


def fault(t: Scalar, wrench: Channels, plant: Plant, numbers: Numbers) -> Channels:
    """u = e h from the onset on, h before."""
    del plant
    return each(lambda h, start, e: jnp.where(t >= start, e * h, h), wrench, numbers.onset_s, numbers.remaining)


COMPONENT = Component(Parameters, lambda parameters: fault)
