"""Disturbances: a file per member. A component's `build(parameters)` gives a `Disturbance`
(`rvjax.components.disturbances.interface`)."""

from __future__ import annotations

MEMBERS = {
    "constant": "rvjax.components.disturbances.constant",
    "sinusoid": "rvjax.components.disturbances.sinusoid",
    "gravity-gradient": "rvjax.components.disturbances.gravity_gradient",
    "ornstein-uhlenbeck": "rvjax.components.disturbances.ornstein_uhlenbeck",
    "differential-drag": "rvjax.components.disturbances.differential_drag",
    "j2-difference": "rvjax.components.disturbances.j2_difference",
    "plume-pulse": "rvjax.components.disturbances.plume_pulse",
    "table": "rvjax.components.disturbances.table",
}
