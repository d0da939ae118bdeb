"""Effort: Δv = ∫ |f|/m dt and angular impulse ∫ |τ| dt of the applied wrench, without disturbances."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from rvjax.columns import Column
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar, norm


class Effort(NamedTuple):
    """Δv [m/s] and angular impulse [N·m·s] so far."""

    delta_v: Scalar
    impulse: Scalar


def start(context: MetricContext) -> Effort:
    zero = context.duration_s * 0.0
    return Effort(zero, zero)


def update(acc: Effort, step: Step, weight: Scalar, context: MetricContext) -> Effort:
    """Δv += |f|/m weight, impulse += |τ| weight."""
    del context
    return Effort(
        acc.delta_v + weight * norm(step.applied.force) / step.plant.mass,
        acc.impulse + weight * norm(step.applied.torque),
    )


def finish(acc: Effort, context: MetricContext) -> Mapping[str, Scalar]:
    del context
    return {"delta_v_m_s": acc.delta_v, "angular_impulse_Nms": acc.impulse}


_COLUMNS = (
    Column("delta_v_m_s", "m/s", "integral of applied force over mass", "lower"),
    Column("angular_impulse_Nms", "N·m·s", "integral of applied torque", "lower"),
)
COMPONENT = Metric({column.name: column for column in _COLUMNS}, start, update, finish)
