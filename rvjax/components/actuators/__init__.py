"""Actuators: what lies between the commanded wrench, or the commanded thrusts, and the faults. A file per member
(`rvjax.components.actuators.interface`)."""

from __future__ import annotations

MEMBERS = {
    "first-order-lag": "rvjax.components.actuators.first_order_lag",
    "rate-limit": "rvjax.components.actuators.rate_limit",
    "quantisation": "rvjax.components.actuators.quantisation",
    "pulse-width": "rvjax.components.actuators.pulse_width",
}
