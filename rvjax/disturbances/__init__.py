"""Disturbances: one file = one member. A component's `build(parameters)` gives a `Disturbance`
(`rvjax.disturbances.interface`)."""

from __future__ import annotations

MEMBERS = {
    "constant": "rvjax.disturbances.constant",
    "sinusoid": "rvjax.disturbances.sinusoid",
    "gravity-gradient": "rvjax.disturbances.gravity_gradient",
    "ornstein-uhlenbeck": "rvjax.disturbances.ornstein_uhlenbeck",
    "differential-drag": "rvjax.disturbances.differential_drag",
    "j2-difference": "rvjax.disturbances.j2_difference",
    "plume-pulse": "rvjax.disturbances.plume_pulse",
    "table": "rvjax.disturbances.table",
}
