"""Actuator faults: one file = one member. A component's `build(parameters)` gives a `Fault` (`rvjax.closed_loop`).

Every fault has an onset per channel and leaves the wrench as it is before it: a channel whose onset is +∞ never fails.
"""

from __future__ import annotations

MEMBERS = {
    "effectiveness": "rvjax.faults.effectiveness",
    "bias": "rvjax.faults.bias",
}
