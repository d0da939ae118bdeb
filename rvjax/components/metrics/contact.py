"""Contact conditions at the port: how the pursuer's docking interface arrives.

    p = Rᵀ(ρ + s) − s,   ṗ = Rᵀ(ν + ω×s) − ω_t×Rᵀρ                                       in T
    contact: the first instant with aᵀp = d that was reached from aᵀp > d, where |a×p| ≤ c
    misalignment |a×p|, closing speed −aᵀṗ, lateral speed |a×ṗ|
    pitch and yaw 2 atan2(|2a×σ|, √((1 − σᵀσ)² + (2aᵀσ)²)), roll 2 atan2(|2aᵀσ|, 1 − σᵀσ)
    pitch and yaw rate |a×Rᵀω|, roll rate |aᵀRᵀω|

a: docking axis, δ/|δ|; s: place of the docking interface, from the pursuer's centre of mass, in P; p: place of the interface,
from where it is when docked; d: `distance_m`; c: `radius_m`. Speeds are those that an observer on the turning target sees. The
angle of pitch and yaw is that between the two docking axes, the angle of roll is the rotation about a that remains (swing and
twist: P. Dobrowolski, "Swing-twist decomposition in Clifford algebra", 2015, arXiv:1506.05481).

The flight goes on after the contact: nothing is pushed or latched. Between the two steps around the contact every value is
interpolated linearly. Without a contact the time is infinite and every other value is not a number (NaN), which complies with no
requirement, whether below or above. A pursuer that begins behind the plane aᵀp = d, or that crosses it farther than c from the
axis, has no contact before it crosses the plane anew. Where the hulls collide every value is NaN, the time too: the contact may
come after the collision, of a pursuer that went through the target.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, NamedTuple

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, Spec, scalar, vector
from rvjax.campaign.problems import Problem
from rvjax.columns import Column
from rvjax.components.effect import has
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.components.registry import Component
from rvjax.physics.elementary import atan2
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar, Vector, cross, dot, norm, rotate_back, rotation


class Parameters(Model):
    """Where contact begins, and what arrives."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"interface_m": [-1.2, 0, 0]},
        {"distance_m": 0.02, "radius_m": 0.5},
    )

    distance_m: Quantity = scalar(
        "m", default=0.05, at_least=0.0, doc="axial distance d of the interface from its docked place at contact"
    )
    radius_m: Quantity = scalar(
        "m", default=1.0, above=0.0, doc="radius c of the port: farther from the docking axis is no contact"
    )
    interface_m: Quantity = vector(
        "m", default=0.0, doc="place s of the docking interface from the pursuer's centre of mass, in the pursuer's frame"
    )


class Arrival(NamedTuple):
    """The columns but for the time: m, m/s, deg, deg/s."""

    lateral: Scalar
    closing_speed: Scalar
    lateral_speed: Scalar
    pitch_yaw: Scalar
    roll: Scalar
    pitch_yaw_rate: Scalar
    roll_rate: Scalar


class Contact(NamedTuple):
    """axial: aᵀp at the last step [m]; before: the values there. time: of the contact [s], ∞ before; at: the values there."""

    axial: Scalar
    before: Arrival
    time: Scalar
    at: Arrival


def start(context: MetricContext) -> Contact:
    """No contact. aᵀp = 0 is not outside."""
    zero = context.duration_s * 0.0
    never = Arrival(*(zero + jnp.nan,) * 7)
    return Contact(zero, Arrival(*(zero,) * 7), zero + jnp.inf, never)


def update(acc: Contact, step: Step, weight: Scalar, context: MetricContext) -> Contact:
    """q = q₋ + λ(q₊ − q₋), λ = (x₋ − d)/(x₋ − x₊), at the first step with x₊ ≤ d < x₋; x = aᵀp."""
    del weight
    axial, now = _arrival(step, context)
    distance = context.numbers.distance_m
    fell = (acc.axial > distance) & (axial <= distance)
    share = jnp.where(fell, acc.axial - distance, 0.0) / jnp.where(fell, acc.axial - axial, 1.0)
    between = Arrival(*(old + share * (new - old) for old, new in zip(acc.before, now, strict=True)))
    first = fell & (between.lateral <= context.numbers.radius_m) & (acc.time == jnp.inf)
    time = jnp.maximum(step.t - (1.0 - share) * context.step_s, 0.0)
    at = Arrival(*(jnp.where(first, new, old) for old, new in zip(acc.at, between, strict=True)))
    return Contact(axial, now, jnp.where(first, time, acc.time), at)


def _arrival(step: Step, context: MetricContext) -> tuple[Scalar, Arrival]:
    """(aᵀp, the values at a step)."""
    a, place, motion = context.axis, context.numbers.interface_m, step.motion
    r = rotation(motion.sigma)
    rho = rotate_back(r, motion.rho)
    p = rho + rotate_back(r, place) - place
    speed = rotate_back(r, motion.nu + cross(motion.omega, place)) - cross(step.target.w, rho)
    pitch_yaw, roll = _angles(motion.sigma, a)
    rate = rotate_back(r, motion.omega)
    about = jnp.abs(dot(a, rate))
    rates = (jnp.rad2deg(norm(cross(a, rate))), jnp.rad2deg(about))
    return dot(a, p), Arrival(norm(cross(a, p)), -dot(a, speed), norm(cross(a, speed)), pitch_yaw, roll, *rates)


def _angles(sigma: Vector, axis: Vector) -> tuple[Scalar, Scalar]:
    """Angle between the axis before and after the rotation, and the rotation about it that remains [deg], for |σ| ≤ 1."""
    cos, along, across = 1.0 - dot(sigma, sigma), 2.0 * jnp.abs(dot(axis, sigma)), 2.0 * norm(cross(axis, sigma))
    swing = 2.0 * atan2(across, jnp.sqrt(cos * cos + along * along))
    return jnp.rad2deg(swing), jnp.rad2deg(2.0 * atan2(along, cos))


def finish(acc: Contact, context: MetricContext) -> Mapping[str, Scalar]:
    """The time and the values at contact."""
    del context
    return dict(zip(_COLUMNS, (acc.time, *acc.at), strict=True))


def silent(parameters: Parameters, campaign: Spec) -> Iterator[Problem]:
    """A problem if there is no docking axis in any sample."""
    del parameters
    if has(campaign.target.port_m, 0.0):
        yield Problem("target.port_m is 0, so there is no docking axis", "accepted: another target.port_m")


_WHAT = (
    ("time_s", "s", "time of the contact; inf: never", "lower"),
    ("lateral_m", "m", "distance of the docking interface from the docking axis at contact", "lower"),
    ("closing_speed_m_s", "m/s", "speed of the docking interface towards the port at contact", ""),
    ("lateral_speed_m_s", "m/s", "speed of the docking interface across the docking axis at contact", "lower"),
    ("pitch_yaw_deg", "deg", "angle between the two docking axes at contact", "lower"),
    ("roll_deg", "deg", "rotation about the docking axis at contact", "lower"),
    ("pitch_yaw_rate_deg_s", "deg/s", "relative rate across the docking axis at contact", "lower"),
    ("roll_rate_deg_s", "deg/s", "relative rate about the docking axis at contact", "lower"),
)
_COLUMNS = {f"contact_{name}": Column(f"contact_{name}", *more) for name, *more in _WHAT}
COMPONENT = Component(Parameters, lambda parameters: Metric(_COLUMNS, start, update, finish), silent=silent)
