"""Float of an actuator channel: it gives nothing, whatever is asked of it.

    u = 0       while the fault acts

The valve that does not open, the wheel that spins freely. With a duration the channel comes back.
"""

from __future__ import annotations

from rvjax.components.faults.interface import FaultParameters, fault
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels


class Parameters(FaultParameters):
    """None of its own."""


def failed(u: Channels, since: Channels, memory: tuple[()], upper: Channels, numbers: Numbers) -> Channels:
    """0."""
    del since, memory, upper, numbers
    return u * 0.0


COMPONENT = Component(Parameters, lambda parameters: fault(failed))
