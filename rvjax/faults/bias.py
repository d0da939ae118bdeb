"""Bias of an actuator channel, as a step.

    u = h + s u⁺              while the fault acts

s: bias as a share of the channel's true upper limit u⁺, of either sign. The usual additive actuator fault (Xia, Huo, 2018).
"""

from __future__ import annotations

from rvjax.algebra import Channels
from rvjax.family import Component
from rvjax.faults.interface import FaultParameters, fault
from rvjax.spec import Quantity, channels
from rvjax.state import Numbers


class Parameters(FaultParameters):
    """Size of the bias, channel by channel."""

    share: Quantity = channels("1", at_least=-1.0, at_most=1.0, doc="bias s as a share of the channel's upper limit")


def failed(u: Channels, since: Channels, memory: tuple[()], upper: Channels, numbers: Numbers) -> Channels:
    """h + s u⁺."""
    del since, memory
    return u + numbers.share * upper


COMPONENT = Component(Parameters, lambda parameters: fault(failed))
