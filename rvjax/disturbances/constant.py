"""Constant disturbance wrench on the pursuer.

d_f(t) = f,   d_τ(t) = τ,   both fixed in P
"""

from __future__ import annotations

from rvjax.algebra import Channels, Scalar
from rvjax.dynamics import Relative
from rvjax.family import Component
from rvjax.spec import Model, Quantity, vector
from rvjax.state import Motion, Numbers, Plant


class Parameters(Model):
    """The wrench, in the pursuer's frame."""

    force_N: Quantity = vector("N", default=0.0, doc="disturbance force f")
    torque_Nm: Quantity = vector("N·m", default=0.0, doc="disturbance torque τ")


def disturbance(t: Scalar, motion: Motion, known: Relative, plant: Plant, numbers: Numbers) -> Channels:
    """(f, τ)."""
    del t, motion, known, plant
    return Channels(numbers.force_N, numbers.torque_Nm)


COMPONENT = Component(Parameters, lambda parameters: disturbance)
