"""Adaptation: largest Nussbaum argument and largest drift of the estimates of an adaptive controller."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import jax.numpy as jnp

from rvjax.columns import Column
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar, each, largest


class Peaks(NamedTuple):
    """Largest |χ| over channels and largest relative drift of the estimates, so far."""

    chi: Scalar
    drift: Scalar


def start(context: MetricContext) -> Peaks:
    zero = context.duration_s * 0.0
    return Peaks(zero, zero)


def update(acc: Peaks, step: Step, weight: Scalar, context: MetricContext) -> Peaks:
    """Running maxima."""
    del weight, context
    return Peaks(jnp.maximum(acc.chi, largest(each(jnp.abs, step.report.chi))), jnp.maximum(acc.drift, step.report.drift))


def finish(acc: Peaks, context: MetricContext) -> Mapping[str, Scalar]:
    del context
    return {"peak_chi": acc.chi, "peak_estimate_drift": acc.drift}


_COLUMNS = (
    Column("peak_chi", "1", "largest |chi| of any Nussbaum gain; 0 for a controller without Nussbaum gains", "lower"),
    Column(
        "peak_estimate_drift",
        "1",
        "largest change of an estimated mass or inertia entry, relative to its initial value; 0 without estimates",
        "lower",
    ),
)
COMPONENT = Metric({column.name: column for column in _COLUMNS}, start, update, finish)
