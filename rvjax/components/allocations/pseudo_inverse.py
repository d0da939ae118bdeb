"""f = clip(f₀ + B⁺(w − B f₀), 0, f_max), f₀ = c f_max.

w: commanded wrench; B, f_max: nominal thrusters; B⁺: the pseudo-inverse for shares of f_max and wrenches weighted by
W = diag(2/(u⁺ + u⁻)), with the nominal limits of the channels. It is linear only while nothing is clipped. All thrusters burn
around their centre f₀.
"""

from __future__ import annotations

from functools import partial

from rvjax.campaign import Model, number
from rvjax.components.registry import Component
from rvjax.physics.thruster_allocation import pseudo_inverse


class Parameters(Model):
    """The thrust around which the thrusters burn."""

    centre: float = number(
        "1", default=0.5, at_least=0.0, at_most=1.0, doc="c: thrust without a command, as a share of the largest thrust"
    )


COMPONENT = Component(Parameters, lambda parameters: partial(pseudo_inverse, centre=parameters.centre))
