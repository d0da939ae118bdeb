"""White noise of the measurement, new in every step and held during it.

    ρ + s_ρ ξ,   ν + s_ν ξ,   R(s_φ ξ/4) R(σ),   ω + s_ω ξ         all in P, ξ: standard normal, independent

s is the standard deviation of a single measurement for any step; a sampled controller reads it only at its sampling instants. The
mean over a time T has the standard deviation s √(h/T), so the effect depends on the step h and the control period.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from rvjax.campaign import Model, Quantity, vector
from rvjax.components.effect import zero
from rvjax.components.navigation.interface import NavigationError, displaced
from rvjax.components.registry import Component
from rvjax.physics.noise import normals
from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar, Vector, each

MEASURED = ("position_m", "velocity_m_s", "attitude_rad", "rate_rad_s")
"""Each has its three random numbers in a step, even if the others have no noise."""


class Parameters(Model):
    """Standard deviation of each component. A quantity that is left out is exact."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"position_m": 0.02},)

    position_m: Quantity | None = vector("m", default=None, at_least=0.0, doc="standard deviation s of the position")
    velocity_m_s: Quantity | None = vector("m/s", default=None, at_least=0.0, doc="standard deviation s of the velocity")
    attitude_rad: Quantity | None = vector(
        "rad", key="attitude_deg", default=None, at_least=0.0, doc="standard deviation s of the attitude"
    )
    rate_rad_s: Quantity | None = vector(
        "rad/s", key="rate_deg_s", default=None, at_least=0.0, doc="standard deviation s of the angular rate"
    )


Errors = Mapping[str, Vector]


def start(motion: Motion, numbers: Numbers) -> Errors:
    """Zero before the flight; the first step draws."""
    del motion
    return {name: numbers[name] * 0.0 for name in MEASURED if name in numbers}


def keep(tick: Tick, motion: Motion, memory: Errors, numbers: Numbers) -> Errors:
    """s ξ_k."""
    del motion
    xi = normals(numbers.noise, tick.k, 3 * len(MEASURED))
    normal = {name: Vector(*xi[3 * place : 3 * place + 3]) for place, name in enumerate(MEASURED)}
    return {name: each(lambda sd, x: sd * x, numbers[name], normal[name]) for name in memory}


def see(t: Scalar, motion: Motion, memory: Errors, numbers: Numbers) -> Motion:
    """The motion with the errors of the step."""
    del t, numbers
    return displaced(motion, memory)


COMPONENT = Component(Parameters, lambda parameters: NavigationError(see, start, keep), noisy=True, neutral=(zero(*MEASURED),))
