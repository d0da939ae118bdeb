"""Metrics: a file per member. Each accumulates over the steps of a flight and gives columns of the samples table
(`rvjax.components.metrics.interface`). A `Metric` is on in every campaign that has what it needs; a component with parameters is
on where the campaign chooses it under `metrics`."""

from __future__ import annotations

MEMBERS = {
    "tubes": "rvjax.components.metrics.convergence",
    "errors": "rvjax.components.metrics.accuracy",
    "saturation": "rvjax.components.metrics.saturation",
    "effort": "rvjax.components.metrics.effort",
    "propellant": "rvjax.components.metrics.propellant",
    "adaptation": "rvjax.components.metrics.adaptation",
    "approach": "rvjax.components.metrics.approach",
    "collision": "rvjax.components.metrics.collision",
    "keep-out-zone": "rvjax.components.metrics.keep_out_zone",
    "keep-out": "rvjax.components.metrics.keep_out",
    "contact": "rvjax.components.metrics.contact",
    "passive-safety": "rvjax.components.metrics.passive_safety",
    "fuel-bound": "rvjax.components.metrics.fuel_bound",
}
