"""Bias of an actuator channel, as a step.

    u = h + s u⁺              while the fault acts

s: bias as a share of the channel's true upper limit u⁺, positive or negative. The usual additive actuator fault (Xia, Huo, 2018).
"""

from __future__ import annotations

from rvjax.campaign import Quantity, channels
from rvjax.components.faults.interface import FaultParameters, fault
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels


class Parameters(FaultParameters):
    """Size of the bias, per channel."""

    share: Quantity = channels("1", at_least=-1.0, at_most=1.0, doc="bias s as a share of the channel's upper limit")


def failed(u: Channels, since: Channels, memory: tuple[()], upper: Channels, numbers: Numbers) -> Channels:
    """h + s u⁺."""
    del since, memory
    return u + numbers.share * upper


COMPONENT = Component(Parameters, lambda parameters: fault(failed), neutral=({"share": 0.0},))
