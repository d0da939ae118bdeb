"""Metrics: one file = one fold over the steps of a flight (`rvjax.metrics.interface`), giving one or more columns."""

from __future__ import annotations

MEMBERS = {
    "tubes": "rvjax.metrics.tubes",
    "errors": "rvjax.metrics.errors",
    "saturation": "rvjax.metrics.saturation",
    "effort": "rvjax.metrics.effort",
    "adaptation": "rvjax.metrics.adaptation",
    "approach": "rvjax.metrics.approach",
}
