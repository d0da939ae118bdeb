"""Convergence: whether and when the pursuer enters the capture tubes, and whether it stays.

A settling time is the end of the last step that began outside the tube; +∞ if the flight ends outside.
captured = both tubes held over the whole closing window.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import jax.numpy as jnp

from rvjax.columns import Column
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar, norm


class Tubes(NamedTuple):
    """Last instant outside the position and the attitude tube [s]; −∞ before the first."""

    position: Scalar
    attitude: Scalar


def start(context: MetricContext) -> Tubes:
    never = jnp.full_like(context.duration_s, -jnp.inf)
    return Tubes(never, never)


def update(acc: Tubes, step: Step, weight: Scalar, context: MetricContext) -> Tubes:
    """Stores the instant if |ρ| or |σ| is outside its tube."""
    del weight
    return Tubes(
        jnp.where(norm(step.motion.rho) <= context.tube_m, acc.position, step.t),
        jnp.where(norm(step.motion.sigma) <= context.tube_mrp, acc.attitude, step.t),
    )


def finish(acc: Tubes, context: MetricContext) -> Mapping[str, Scalar]:
    """Settling: a step after the last instant outside, 0 if never outside, +∞ if the last instant is outside."""

    def settled(last: Scalar) -> Scalar:
        after = jnp.maximum(last + context.step_s, 0.0)
        after = jnp.minimum(after, context.duration_s)  # where the sum exceeds the duration by its rounding error
        return jnp.where(last > context.duration_s - 0.5 * context.step_s, jnp.inf, after)

    position, attitude = settled(acc.position), settled(acc.attitude)
    both = jnp.maximum(position, attitude)
    held = jnp.maximum(acc.position, acc.attitude) < context.window_start_s - 1e-6 * context.step_s
    recovery = jnp.where(jnp.isfinite(context.last_onset_s), jnp.maximum(both - context.last_onset_s, 0.0), 0.0)
    return {
        "captured": held * 1.0,
        "settling_time_s": position,
        "attitude_settling_time_s": attitude,
        "fault_recovery_s": recovery,
    }


_COLUMNS = (
    Column("captured", "1", "1 if both tubes were held over the whole closing window, else 0", "higher"),
    Column("settling_time_s", "s", "time from which the position error stays inside its tube; inf: never", "lower"),
    Column("attitude_settling_time_s", "s", "time from which the attitude error stays inside its tube; inf: never", "lower"),
    Column("fault_recovery_s", "s", "time from the last fault onset until both tubes hold; 0 without a fault", "lower"),
)
COMPONENT = Metric({column.name: column for column in _COLUMNS}, start, update, finish)
