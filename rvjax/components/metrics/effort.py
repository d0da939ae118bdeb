"""Effort of the actuators behind the faults, without disturbances. Actuators that push against each other add up.

    I = ∫ F dt,   Δv = ∫ F/m dt        F = Σ fᵢ of the thrusters, or |f_x| + |f_y| + |f_z| of the six channels
    H = ∫ |τ| dt                       τ: applied torque

Each channel stands for a pair of thrusters along its axis. m: mass of the instant. With propellant and no torque arm
I = I_sp g₀ m_c and Δv = I_sp g₀ ln(m₀/m) (`rvjax.physics.propellant`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from rvjax.columns import Column
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.physics.propellant import thrust_sum
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar, norm


class Effort(NamedTuple):
    """Δv [m/s], I [N·s] and H [N·m·s] so far."""

    delta_v: Scalar
    thrust: Scalar
    angular: Scalar


def start(context: MetricContext) -> Effort:
    zero = context.duration_s * 0.0
    return Effort(zero, zero, zero)


def update(acc: Effort, step: Step, weight: Scalar, context: MetricContext) -> Effort:
    """Δv += F/m weight, I += F weight, H += |τ| weight."""
    del context
    impulse = weight * thrust_sum(step.applied, step.thrusts)
    return Effort(
        acc.delta_v + impulse / step.plant.mass,
        acc.thrust + impulse,
        acc.angular + weight * norm(step.applied.torque),
    )


def finish(acc: Effort, context: MetricContext) -> Mapping[str, Scalar]:
    del context
    return {"delta_v_m_s": acc.delta_v, "thrust_impulse_Ns": acc.thrust, "angular_impulse_Nms": acc.angular}


_COLUMNS = (
    Column("delta_v_m_s", "m/s", "integral of the sum of all thrusts over mass", "lower"),
    Column("thrust_impulse_Ns", "N·s", "integral of the sum of all thrusts", "lower"),
    Column("angular_impulse_Nms", "N·m·s", "integral of applied torque", "lower"),
)
COMPONENT = Metric({column.name: column for column in _COLUMNS}, start, update, finish)
