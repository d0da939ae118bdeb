"""Constant disturbance wrench on the pursuer.

d_f(t) = f,   d_τ(t) = τ,   both fixed in P
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from rvjax.campaign import Model, Quantity, vector
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.effect import zero
from rvjax.components.registry import Component
from rvjax.physics.dynamics import Relative
from rvjax.physics.state import Numbers, Plant, State
from rvjax.physics.vectors import Channels, Scalar


class Parameters(Model):
    """The wrench, in P."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"force_N": [0.01, 0, 0]},)

    force_N: Quantity = vector("N", default=0.0, doc="disturbance force f")
    torque_Nm: Quantity = vector("N·m", default=0.0, doc="disturbance torque τ")


def push(t: Scalar, y: State, known: Relative, plant: Plant, memory: tuple[()], numbers: Numbers) -> Channels:
    """(f, τ)."""
    del t, y, known, plant, memory
    return Channels(numbers.force_N, numbers.torque_Nm)


COMPONENT = Component(Parameters, lambda parameters: Disturbance(push), neutral=(zero("force_N", "torque_Nm"),))
