"""Float of an actuator channel: it gives nothing, whatever is asked of it.

    u = 0       while the fault acts

The valve that does not open, the wheel that spins freely. With a duration the channel comes back.
"""

from __future__ import annotations

from rvjax.algebra import Channels
from rvjax.family import Component
from rvjax.faults.interface import FaultParameters, fault
from rvjax.state import Numbers


class Parameters(FaultParameters):
    """None of its own."""


def failed(u: Channels, since: Channels, memory: tuple[()], upper: Channels, numbers: Numbers) -> Channels:
    """0."""
    del since, memory, upper, numbers
    return u * 0.0


COMPONENT = Component(Parameters, lambda parameters: fault(failed))
