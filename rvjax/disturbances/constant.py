"""Constant disturbance wrench on the pursuer.

d_f(t) = f,   d_τ(t) = τ,   both fixed in P
"""

from __future__ import annotations

from rvjax.algebra import Channels, Scalar
from rvjax.disturbances.interface import Disturbance
from rvjax.dynamics import Relative
from rvjax.family import Component
from rvjax.spec import Model, Quantity, vector
from rvjax.state import Numbers, Plant, State


class Parameters(Model):
    """The wrench, in the pursuer's frame."""

    force_N: Quantity = vector("N", default=0.0, doc="disturbance force f")
    torque_Nm: Quantity = vector("N·m", default=0.0, doc="disturbance torque τ")


def push(t: Scalar, y: State, known: Relative, plant: Plant, memory: tuple[()], numbers: Numbers) -> Channels:
    """(f, τ)."""
    del t, y, known, plant, memory
    return Channels(numbers.force_N, numbers.torque_Nm)


COMPONENT = Component(Parameters, lambda parameters: Disturbance(push))
