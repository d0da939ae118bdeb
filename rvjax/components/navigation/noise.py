"""White noise of the measurement, new in every step and held during it.

    ρ + s_ρ ξ,   ν + s_ν ξ,   R(s_φ ξ/4) R(σ),   ω + s_ω ξ         all in P, ξ: standard normal, independent
    √(s² + (g|ρ|)²) in the place of s                              with a growth g

Many sensors lose accuracy with the range |ρ|: the distance from the docking point at the beginning of the step.

s is the standard deviation of a single measurement for any step; a sampled controller reads it only at its sampling instants. The
mean over a time T has the standard deviation s √(h/T), so the effect depends on the step h and the control period.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, vector
from rvjax.components.effect import zero
from rvjax.components.navigation.interface import NavigationError, displaced
from rvjax.components.registry import Component
from rvjax.physics.noise import normals
from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar, Vector, dot, each

MEASURED = ("position_m", "velocity_m_s", "attitude_rad", "rate_rad_s")
"""Each has its three random numbers in a step, even if the others have no noise."""

GROWTH = "_per_m"
"""What the name of a growth ends in."""


class Parameters(Model):
    """Standard deviation of each component. A quantity that is left out is exact."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"position_m": 0.02},
        {"position_m": 0.002, "position_m_per_m": 0.005, "attitude_deg": 0.05},
    )

    position_m: Quantity | None = vector("m", default=None, at_least=0.0, doc="standard deviation s of the position")
    velocity_m_s: Quantity | None = vector("m/s", default=None, at_least=0.0, doc="standard deviation s of the velocity")
    attitude_rad: Quantity | None = vector(
        "rad", key="attitude_deg", default=None, at_least=0.0, doc="standard deviation s of the attitude"
    )
    rate_rad_s: Quantity | None = vector(
        "rad/s", key="rate_deg_s", default=None, at_least=0.0, doc="standard deviation s of the angular rate"
    )
    position_m_per_m: Quantity | None = vector("m/m", default=None, at_least=0.0, doc="growth g of the position's with the range")
    velocity_m_s_per_m: Quantity | None = vector(
        "(m/s)/m", default=None, at_least=0.0, doc="growth g of the velocity's with the range"
    )
    attitude_rad_per_m: Quantity | None = vector(
        "rad/m", key="attitude_deg_per_m", default=None, at_least=0.0, doc="growth g of the attitude's with the range"
    )
    rate_rad_s_per_m: Quantity | None = vector(
        "(rad/s)/m", key="rate_deg_s_per_m", default=None, at_least=0.0, doc="growth g of the angular rate's with the range"
    )


Errors = Mapping[str, Vector]


def start(motion: Motion, numbers: Numbers) -> Errors:
    """Zero before the flight; the first step draws."""
    del motion
    zeros = {name: numbers[given] * 0.0 for name in MEASURED for given in (name, f"{name}{GROWTH}") if given in numbers}
    return {name: zeros[name] for name in MEASURED if name in zeros}


def keep(tick: Tick, motion: Motion, memory: Errors, numbers: Numbers) -> Errors:
    """s ξ_k, √(s² + (g|ρ|)²) ξ_k with a growth g."""
    xi = normals(numbers.noise, tick.k, 3 * len(MEASURED))
    normal = {name: Vector(*xi[3 * place : 3 * place + 3]) for place, name in enumerate(MEASURED)}
    return {name: each(lambda sd, x: sd * x, deviation(name, motion, numbers), normal[name]) for name in memory}


def deviation(name: str, motion: Motion, numbers: Numbers) -> Vector:
    """The standard deviation of a quantity at the range of a motion."""
    if f"{name}{GROWTH}" not in numbers:
        return numbers[name]
    growth, range2 = numbers[f"{name}{GROWTH}"], dot(motion.rho, motion.rho)
    variance = each(lambda g: g * g * range2, growth)
    if name in numbers:
        variance = each(lambda v, s: v + s * s, variance, numbers[name])
    return each(lambda v: jnp.where(v > 0.0, jnp.sqrt(jnp.where(v > 0.0, v, 1.0)), 0.0), variance)


def see(t: Scalar, motion: Motion, memory: Errors, numbers: Numbers) -> Motion:
    """The motion with the errors of the step."""
    del t, numbers
    return displaced(motion, memory)


NEUTRAL = (zero(*MEASURED, *(f"{name}{GROWTH}" for name in MEASURED)),)

COMPONENT = Component(Parameters, lambda parameters: NavigationError(see, start, keep), noisy=True, neutral=NEUTRAL)
