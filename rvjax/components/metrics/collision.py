"""Collision: the smallest distance between the two hulls, bounded between the steps as well.

    clearance = min over the steps of  max over n of min(s_k(n), s_{k+1}(n)) − A h²/8           (`rvjax.physics.hulls`)
    A = 2 max(a_k, a_{k+1})
    a = (|u_f| + |f|)/m + 2μ|x|/|r_t|³ + 2|ω_t||v| + (|ω_t|² + |ω̇_t|)|x| + l(|ω|² + α)
    α = tr J⁻¹ (|u_τ| + |c||u_f| + |τ| + tr J |Ω|²) + |ω||ω_t| + |ω̇_t|

a: a bound of the acceleration of every point of the pursuer's hull in the target's frame T at an instant, from the equations of
motion (`rvjax.physics.dynamics`). x, v: place from the target's centre of mass and velocity, in T; f, τ: total wrench on the
centre of mass c (actuators, disturbances, effects); u: limits of the actuators, so that they may do anything within a step;
l: largest distance of the hull from the centre of mass. A bounds the acceleration within a step as long as a grows there to no
more than twice its larger value at the two ends.

A sample whose clearance is not above 0 is counted as collided: the hulls met, or the bound cannot exclude it. The flight goes on
as if nothing had happened, so the clearance says how deep the hulls were in each other.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp

from rvjax.columns import Column
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.physics.constants import MU_EARTH
from rvjax.physics.dynamics import target_alpha
from rvjax.physics.hulls import Hull, Pose, least_distance, length, pose
from rvjax.physics.state import Step
from rvjax.physics.vectors import Channels, Rotation, Scalar, Vector, cross, dot, each, rotate, rotate_back, rotation


class Collision(NamedTuple):
    """before, bound: pose and a at the last instant. clearance [m], and where it was smallest: along and from the docking axis
    [m]. time [s], speed [m/s]: of the first collision."""

    before: Pose
    bound: Scalar
    clearance: Scalar
    axial: Scalar
    lateral: Scalar
    time: Scalar
    speed: Scalar


def start(context: MetricContext) -> Collision:
    """Before the first instant the clearance is +∞."""
    zero = context.duration_s * 0.0
    nothing = Vector(zero, zero, zero)
    return Collision(Pose(nothing, Rotation(nothing, nothing, nothing)), zero, zero + jnp.inf, zero, zero, zero + jnp.inf, zero)


def update(acc: Collision, step: Step, weight: Scalar, context: MetricContext) -> Collision:
    """The bound over the step that ends at this instant; at the first instant the bound of the distance itself.

    A number that is not finite changes nothing: neither a lost motion, nor the wrench of a controller that fails at this instant.
    """
    del weight
    target, pursuer = _hulls(step, context)
    r = rotation(step.motion.sigma)
    rho = rotate_back(r, step.motion.rho)
    velocity = rotate_back(r, step.motion.nu) - cross(step.target.w, rho)
    now, bound = pose(target, pursuer, rho + step.plant.port, r), _bound(pursuer, step, r, rho + step.plant.port, velocity)
    first = acc.clearance == jnp.inf
    before = jax.tree.map(lambda new, old: jnp.where(first, new, old), now, acc.before)
    larger = jnp.where(bound > acc.bound, bound, acc.bound)
    margin = jnp.where(first, 0.0, larger * (context.step_s * context.step_s * 0.25))
    distance = least_distance(target, pursuer, before, now) - margin
    nearer, hit = distance < acc.clearance, (distance <= 0.0) & (acc.time == jnp.inf)
    along = dot(context.axis, rho)
    return Collision(
        before=now,
        bound=bound,
        clearance=jnp.where(nearer, distance, acc.clearance),
        axial=jnp.where(nearer, along, acc.axial),
        lateral=jnp.where(nearer, length(rho - context.axis * along), acc.lateral),
        time=jnp.where(hit, step.t, acc.time),
        speed=jnp.where(hit, length(velocity), acc.speed),
    )


def _hulls(step: Step, context: MetricContext) -> tuple[Hull, Hull]:
    """The target's hull, and the pursuer's from its centre of mass."""
    target, pursuer = context.hulls  # pyright: ignore[reportAssignmentType]  # the metric is on only with both
    return target, pursuer._replace(centre=pursuer.centre - step.plant.centre)


def _bound(pursuer: Hull, step: Step, r: Rotation, place: Vector, velocity: Vector) -> Scalar:
    """a of the module's text [m/s²]. place: x; velocity: v, in T."""
    motion, plant, w = step.motion, step.plant, step.target.w
    most, wrench = each(jnp.maximum, plant.upper, plant.lower), step.total
    assert isinstance(wrench, Channels)
    force = length(most.force) + length(wrench.force)
    lever = length(most.torque) + length(plant.centre) * length(most.force) + length(wrench.torque)
    spin, turn, rate = length(motion.omega), length(w), length(motion.omega + rotate(r, w))
    swing = length(target_alpha(w, plant.target_inertia, plant.target_inertia_inverse))
    inertia, inverse = plant.inertia, plant.inertia_inverse
    alpha = (lever + rate * rate * (inertia.xx + inertia.yy + inertia.zz)) * (inverse.xx + inverse.yy + inverse.zz)
    height, away = length(step.target.r), length(place)
    tide = 2.0 * MU_EARTH / (height * height * height)
    frame = (tide + turn * turn + swing) * away + 2.0 * turn * length(velocity)
    return force / plant.mass + frame + pursuer.reach * (spin * spin + alpha + spin * turn + swing)


def finish(acc: Collision, context: MetricContext) -> Mapping[str, Scalar]:
    """The five columns."""
    del context
    return {
        "hull_clearance_m": acc.clearance,
        "closest_axial_m": acc.axial,
        "closest_lateral_m": acc.lateral,
        "collision_time_s": acc.time,
        "collision_speed_m_s": acc.speed,
    }


COLLISION_TIME = Column("collision_time_s", "s", "end of the step in which the hulls collided; inf: never", "higher")
_COLUMNS = (
    Column("hull_clearance_m", "m", "lower bound of the distance between the hulls over the whole flight", "higher"),
    Column("closest_axial_m", "m", "where the hulls were closest: along the docking axis from the docking point, outward"),
    Column("closest_lateral_m", "m", "where the hulls were closest: distance of the pursuer from the docking axis"),
    COLLISION_TIME,
    Column("collision_speed_m_s", "m/s", "speed of the pursuer in the target's frame at the collision; 0 without one", "lower"),
)
COMPONENT = Metric(
    {column.name: column for column in _COLUMNS}, start, update, finish, needs=("target.hull", "pursuer.hull"), safety=True
)
