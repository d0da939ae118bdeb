"""White noise of what is measured, new in every step and held during it.

    ρ + s_ρ ξ,   ν + s_ν ξ,   R(s_φ ξ/4) R(σ),   ω + s_ω ξ         all in P, ξ: standard normal, independent

The size is that of one measurement, whatever the step; a controller that is sampled sees it at its instants only. Averaged over a
time T it is s √(h/T), so another step h or another control period is another noise.
"""

from __future__ import annotations

from collections.abc import Mapping

from rvjax.campaign import Model, Quantity, vector
from rvjax.components.navigation.interface import NavigationError, displaced
from rvjax.components.registry import Component
from rvjax.physics.noise import normals
from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar, Vector, each

MEASURED = ("position_m", "velocity_m_s", "attitude_rad", "rate_rad_s")
"""Each has its own three random numbers of a step, whether the others are noisy or not."""


class Parameters(Model):
    """Standard deviation of each component; what is left out is exact."""

    position_m: Quantity | None = vector("m", default=None, at_least=0.0, doc="of the position")
    velocity_m_s: Quantity | None = vector("m/s", default=None, at_least=0.0, doc="of the velocity")
    attitude_rad: Quantity | None = vector("rad", key="attitude_deg", default=None, at_least=0.0, doc="of the attitude")
    rate_rad_s: Quantity | None = vector("rad/s", key="rate_deg_s", default=None, at_least=0.0, doc="of the angular rate")


Errors = Mapping[str, Vector]


def start(motion: Motion, numbers: Numbers) -> Errors:
    """None before the flight; the first step draws."""
    del motion
    return {name: numbers[name] * 0.0 for name in MEASURED if name in numbers}


def keep(tick: Tick, motion: Motion, memory: Errors, numbers: Numbers) -> Errors:
    """s ξ_k."""
    del motion
    xi = normals(numbers.noise, tick.k, 3 * len(MEASURED))
    own = {name: Vector(*xi[3 * place : 3 * place + 3]) for place, name in enumerate(MEASURED)}
    return {name: each(lambda sd, x: sd * x, numbers[name], own[name]) for name in memory}


def see(t: Scalar, motion: Motion, memory: Errors, numbers: Numbers) -> Motion:
    """The motion, displaced by the errors of the step."""
    del t, numbers
    return displaced(motion, memory)


COMPONENT = Component(Parameters, lambda parameters: NavigationError(see, start, keep), noisy=True)
