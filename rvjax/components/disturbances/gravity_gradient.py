"""Gravity-gradient torque on the pursuer.

    d_τ = 3μ/|r|⁵ r×Jr,   r: from the Earth's centre to the pursuer, in P;   J: the true inertia

P. Hughes, "Spacecraft attitude dynamics", 2004, §8.1.
"""

from __future__ import annotations

from collections.abc import Iterator

from rvjax.campaign import Model, Spec
from rvjax.campaign.problems import Problem
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.effect import has
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


def silent(parameters: Parameters, campaign: Spec) -> Iterator[Problem]:
    """A problem if J is that of a sphere in every sample: r×Jr = 0 then, up to rounding."""
    del parameters
    moments, products = campaign.pursuer.inertia_kgm2.entries
    ends = {end for support in moments.supports for end in support}
    if len(ends) == 1 and (products is None or has(products, 0.0)) and has(campaign.pursuer.centre_of_mass_m, 0.0):
        yield Problem("the pursuer has the same moment of inertia about every axis", "accepted: another pursuer.inertia_kgm2")


COMPONENT = Component(Parameters, lambda parameters: Disturbance(push), silent=silent)
