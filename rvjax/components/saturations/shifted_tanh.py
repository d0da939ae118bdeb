"""h = s tanh((v−c)/s) + c, h' = 1 − tanh²((v−c)/s), c = (u⁺−u⁻)/2, s = (u⁺+u⁻)/2.

Smooth and asymmetric; it does not pass through zero unless both limits are equal.
"""

from __future__ import annotations

from rvjax.campaign import Model
from rvjax.components.registry import Component
from rvjax.physics.saturation import shifted_tanh


class Parameters(Model):
    """None."""


COMPONENT = Component(Parameters, lambda parameters: shifted_tanh)
