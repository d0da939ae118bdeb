"""Reversal of an actuator channel: its output has the wrong sign.

    u = −e h,  0 < e ≤ 1       while the fault acts

e: effectiveness of the reversed channel; 1: full. Two wires or two lines of a valve pair that were swapped, a reaction wheel
whose motor runs the wrong way. A control law that knows the direction of its actuators feeds its error back with the wrong sign.
A thruster can only push, so the fault needs actuators that are six channels.
"""

from __future__ import annotations

from typing import Any, Self

from pydantic import ValidationInfo, model_validator

from rvjax.campaign import Quantity, channels
from rvjax.campaign.problems import Problem, refuse
from rvjax.columns import CHANNELS
from rvjax.components.faults.interface import FaultParameters, fault
from rvjax.components.registry import Component
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels


class Parameters(FaultParameters):
    """Effectiveness of the reversed channel."""

    remaining: Quantity = channels("1", default=1.0, above=0.0, at_most=1.0, doc="effectiveness e of the reversed channel")

    @model_validator(mode="after")
    def _two_sided(self, info: ValidationInfo) -> Self:
        """A thrust stays between 0 and its limit: a reversed thruster would be one that floats."""
        context: dict[str, Any] = info.context or {}
        if context.get("actuators", CHANNELS) != CHANNELS:
            accepted = "accepted: actuators with upper and lower limits, or a thruster fault such as float or effectiveness"
            refuse(Problem("a thruster cannot pull, so it cannot be reversed", accepted, ("use",)))
        return self


def failed(u: Channels, since: Channels, memory: tuple[()], upper: Channels, numbers: Numbers) -> Channels:
    """−e h."""
    del since, memory, upper
    return -(numbers.remaining * u)


COMPONENT = Component(Parameters, lambda parameters: fault(failed))
