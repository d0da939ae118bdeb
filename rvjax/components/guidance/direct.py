"""No guidance: the controller is told the docking point from the first instant on.

ρ, ν: relative to the docking point
"""

from __future__ import annotations

from rvjax.campaign import Model
from rvjax.components.registry import Component


class Parameters(Model):
    """Nothing to choose."""


COMPONENT = Component(Parameters, lambda parameters: None)
