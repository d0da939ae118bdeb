"""Gravity-gradient torque on the pursuer.

    d_τ = 3μ/|r|⁵ r×Jr,   r: from the Earth's centre to the pursuer, in P;   J: the true inertia

P. Hughes, "Spacecraft attitude dynamics", 2004, §8.1.
"""

from __future__ import annotations

from rvjax.campaign import Model
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.registry import Component
from rvjax.physics.dynamics import Relative, gravity_gradient
from rvjax.physics.state import Numbers, Plant, State
from rvjax.physics.vectors import Channels, Scalar


class Parameters(Model):
    """No parameters: the torque follows from the motion."""


def push(t: Scalar, y: State, known: Relative, plant: Plant, memory: tuple[()], numbers: Numbers) -> Channels:
    """(0, 3μ/|r|⁵ r×Jr)."""
    del t, memory, numbers
    return Channels(y.motion.rho * 0.0, gravity_gradient(known.position, plant.inertia))


COMPONENT = Component(Parameters, lambda parameters: Disturbance(push))
