"""Disturbances: one file = one member. A component's `build(parameters)` gives a `Disturbance`
(`rvjax.disturbances.interface`)."""

from __future__ import annotations

MEMBERS = {
    "constant": "rvjax.disturbances.constant",
    "sinusoid": "rvjax.disturbances.sinusoid",
    "gravity-gradient": "rvjax.disturbances.gravity_gradient",
}
