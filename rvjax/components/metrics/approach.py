"""Safety of the approach: closest distance between the two bodies' centres of mass, and time outside the approach cone.

The cone has its axis along the docking axis a, fixed in the target. At the docking point it is `corridor.radius_m` wide, so its
apex lies r/tan(half angle) behind it. It counts up to `corridor.length_m` from the docking point. Time inside the capture tube
does not count, because the direction of ρ has no meaning there.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import jax.numpy as jnp

from rvjax.columns import Column
from rvjax.components.metrics.interface import Funnel, Metric, MetricContext
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar, Vector, dot, norm, rotate_back, rotation


class Approach(NamedTuple):
    """Smallest |r_p − R r_t| [m]; time outside the cone [s]."""

    closest: Scalar
    outside: Scalar


def start(context: MetricContext) -> Approach:
    return Approach(jnp.full_like(context.duration_s, jnp.inf), context.duration_s * 0.0)


def update(acc: Approach, step: Step, weight: Scalar, context: MetricContext) -> Approach:
    """In T: d = Rᵀρ + δ; outside the cone where |ρ| > tube."""
    rho = rotate_back(rotation(step.motion.sigma), step.motion.rho)
    distance = norm(rho)
    outside = outside_cone(rho, context) & (distance > context.tube_m)
    if isinstance(context.funnel, Funnel):
        outside = outside & (distance <= context.funnel.length_m)
    return Approach(jnp.minimum(acc.closest, norm(rho + step.plant.port)), acc.outside + jnp.where(outside, weight, 0.0))


def outside_cone(rho: Vector, context: MetricContext) -> Scalar:
    """aᵀq < |q| cos(half angle),  q = ρ + a r/tan(half angle): from the apex; ρ in T [m]."""
    q = rho + context.axis * context.funnel.apex_m if isinstance(context.funnel, Funnel) else rho
    return dot(context.axis, q) < context.cone * norm(q)


def finish(acc: Approach, context: MetricContext) -> Mapping[str, Scalar]:
    """The sum of the weights may exceed the duration by its rounding error; the time outside does not."""
    return {"closest_approach_m": acc.closest, "corridor_violation_s": jnp.minimum(acc.outside, context.duration_s)}


_COLUMNS = (
    Column("closest_approach_m", "m", "smallest distance between the two centres of mass", "higher"),
    Column("corridor_violation_s", "s", "time outside the approach cone, except inside the capture tube", "lower"),
)
COMPONENT = Metric({column.name: column for column in _COLUMNS}, start, update, finish, safety=True)
