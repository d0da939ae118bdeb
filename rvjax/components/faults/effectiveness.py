"""Loss of effectiveness of an actuator channel, as a step.

    u = e h,  0 ≤ e ≤ 1       while the fault acts

e = 1: healthy; e = 0: lost. The usual multiplicative actuator fault (Xia, Huo, 2018).
"""

from __future__ import annotations

from rvjax.campaign import Quantity, channels
from rvjax.components.faults.interface import FaultParameters, fault
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels


class Parameters(FaultParameters):
    """Remaining effectiveness, per channel."""

    remaining: Quantity = channels("1", at_least=0.0, at_most=1.0, doc="effectiveness e after the onset")


def failed(u: Channels, since: Channels, memory: tuple[()], upper: Channels, numbers: Numbers) -> Channels:
    """e h."""
    del since, memory, upper
    return numbers.remaining * u


COMPONENT = Component(Parameters, lambda parameters: fault(failed), neutral=({"remaining": 1.0},))
