"""Metrics: one file = one fold over the steps of a flight (`rvjax.components.metrics.interface`), giving one or more columns."""

from __future__ import annotations

MEMBERS = {
    "tubes": "rvjax.components.metrics.convergence",
    "errors": "rvjax.components.metrics.accuracy",
    "saturation": "rvjax.components.metrics.saturation",
    "effort": "rvjax.components.metrics.effort",
    "adaptation": "rvjax.components.metrics.adaptation",
    "approach": "rvjax.components.metrics.approach",
}
