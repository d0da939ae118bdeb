"""Accuracy: errors at the end of the flight, and largest errors over the closing window.

Attitude error: principal rotation angle 4 atan|σ|.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import jax.numpy as jnp

from rvjax.columns import Column
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.physics.elementary import atan
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar, norm


class Errors(NamedTuple):
    """|ρ| [m], |σ|, |ν| [m/s], |ω| [rad/s]."""

    position: Scalar
    attitude: Scalar
    velocity: Scalar
    rate: Scalar


class Accuracy(NamedTuple):
    """The latest errors, and the largest since the closing window began."""

    latest: Errors
    worst: Errors


def start(context: MetricContext) -> Accuracy:
    zero = context.duration_s * 0.0
    return Accuracy(Errors(zero, zero, zero, zero), Errors(zero, zero, zero, zero))


def update(acc: Accuracy, step: Step, weight: Scalar, context: MetricContext) -> Accuracy:
    """latest = now; worst = max(worst, now) inside the closing window."""
    del weight
    motion = step.motion
    now = Errors(norm(motion.rho), norm(motion.sigma), norm(motion.nu), norm(motion.omega))
    closing = step.t >= context.window_start_s - 1e-6 * context.step_s
    worst = Errors(*(jnp.where(closing, jnp.maximum(old, new), old) for old, new in zip(acc.worst, now, strict=True)))
    return Accuracy(now, worst)


def finish(acc: Accuracy, context: MetricContext) -> Mapping[str, Scalar]:
    """The eight columns; angles in degrees."""
    del context
    values: dict[str, Scalar] = {}
    for prefix, errors in (("final", acc.latest), ("window", acc.worst)):
        values[f"{prefix}_position_error_m"] = errors.position
        values[f"{prefix}_attitude_error_deg"] = jnp.rad2deg(4.0 * atan(errors.attitude))
        values[f"{prefix}_velocity_error_m_s"] = errors.velocity
        values[f"{prefix}_rate_error_deg_s"] = jnp.rad2deg(errors.rate)
    return values


_WHEN = {"final": "at the end of the flight", "window": "worst over the closing window"}
_WHAT = {
    "position_error_m": ("m", "distance from the docking point"),
    "attitude_error_deg": ("deg", "rotation angle from the target frame"),
    "velocity_error_m_s": ("m/s", "velocity error"),
    "rate_error_deg_s": ("deg/s", "angular rate relative to the target"),
}
_COLUMNS = tuple(
    Column(f"{prefix}_{name}", unit, f"{text}, {when}", "lower")
    for prefix, when in _WHEN.items()
    for name, (unit, text) in _WHAT.items()
)
COMPONENT = Metric({column.name: column for column in _COLUMNS}, start, update, finish)
