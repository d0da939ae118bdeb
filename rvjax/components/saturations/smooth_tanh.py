"""h = u_m tanh(v/u_m), h' = 1 − tanh²(v/u_m), u_m = u⁺ for v ≥ 0, else u⁻.

Smooth and asymmetric: h(0) = 0, h'(0) = 1, and h is twice continuously differentiable. A reconstruction of the modified smooth
hyperbolic tangent of K. Xia, W. Huo, ISA Transactions, 2018.
"""

from __future__ import annotations

from rvjax.campaign import Model
from rvjax.components.registry import Component
from rvjax.physics.saturation import smooth_tanh


class Parameters(Model):
    """None."""


COMPONENT = Component(Parameters, lambda parameters: smooth_tanh)
