"""f = arg min |W(B f − w)|² + ε Σ (fᵢ/f_max,ᵢ)² over 0 ≤ f ≤ f_max.

w: commanded wrench; B, f_max: nominal thrusters; W = diag(2/(u⁺ + u⁻)), with the nominal limits of the channels; ε = 1e-4.
It uses the whole attainable set: inside it the relative error of the wrench is about ε, outside it the weighted error is least.
`rvjax explain allocation` has the iterations that solve it.
"""

from __future__ import annotations

from rvjax.campaign import Model
from rvjax.components.registry import Component
from rvjax.physics.thruster_allocation import bounded_least_squares


class Parameters(Model):
    """None."""


COMPONENT = Component(Parameters, lambda parameters: bounded_least_squares)
