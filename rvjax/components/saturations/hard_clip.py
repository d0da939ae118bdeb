"""h = min(max(v, −u⁻), u⁺); h' = 1 strictly inside the limits, 0 outside.

The true actuator, which the smooth forms approximate.
"""

from __future__ import annotations

from rvjax.campaign import Model
from rvjax.components.registry import Component
from rvjax.physics.saturation import hard_clip


class Parameters(Model):
    """None."""


COMPONENT = Component(Parameters, lambda parameters: hard_clip)
