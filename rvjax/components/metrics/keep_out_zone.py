"""Time inside the keep-out zone of the target and outside of the approach cone.

    inside:  Σ (xᵢ/aᵢ)² < 1,   x = Rᵀρ + δ: the pursuer's centre of mass from the target's, in T;  aᵢ: target.keep_out.radii_m

The cone leads through the zone to the docking point; it counts here at every distance. Inside the capture tube no time counts.
"""

from __future__ import annotations

from collections.abc import Mapping

import jax.numpy as jnp

from rvjax.columns import Column
from rvjax.components.metrics.approach import outside_cone
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar, dot, each, norm, rotate_back, rotation


def start(context: MetricContext) -> Scalar:
    """0 s."""
    return context.duration_s * 0.0


def update(acc: Scalar, step: Step, weight: Scalar, context: MetricContext) -> Scalar:
    """Adds the weight of an instant inside."""
    rho = rotate_back(rotation(step.motion.sigma), step.motion.rho)
    share = each(lambda x, a: x / a, rho + step.plant.port, context.keep_out)
    inside = (dot(share, share) < 1.0) & outside_cone(rho, context) & (norm(rho) > context.tube_m)
    return acc + jnp.where(inside, weight, 0.0)


def finish(acc: Scalar, context: MetricContext) -> Mapping[str, Scalar]:
    """The sum of the weights may exceed the duration by its rounding error; the time does not."""
    return {"keep_out_violation_s": jnp.minimum(acc, context.duration_s)}


COLUMN = Column("keep_out_violation_s", "s", "time inside the keep-out zone and outside of the approach cone", "lower")
COMPONENT = Metric({COLUMN.name: COLUMN}, start, update, finish, needs=("target.keep_out",), safety=True)
