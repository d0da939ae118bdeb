"""Float of an actuator channel: its output is zero for any command.

    u = 0       while the fault acts

A valve that does not open, a wheel that spins freely. With a duration, the channel recovers.
"""

from __future__ import annotations

from rvjax.components.faults.interface import FaultParameters, fault
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels


class Parameters(FaultParameters):
    """No further parameters."""


def failed(u: Channels, since: Channels, memory: tuple[()], upper: Channels, numbers: Numbers) -> Channels:
    """0."""
    del since, memory, upper, numbers
    return u * 0.0


COMPONENT = Component(Parameters, lambda parameters: fault(failed))
