"""Actuator faults: one file = one member. A component's `build(parameters)` gives a `Fault` (`rvjax.faults.interface`).

Every fault has an onset per channel and leaves the wrench as it is before it, bit for bit; it may end again, be intermittent, and
befall only some channels of a sample. Faults act one after the other in the order of the campaign.
"""

from __future__ import annotations

MEMBERS = {
    "effectiveness": "rvjax.faults.effectiveness",
    "incipient": "rvjax.faults.incipient",
    "bias": "rvjax.faults.bias",
    "drift": "rvjax.faults.drift",
    "stuck": "rvjax.faults.stuck",
    "float": "rvjax.faults.float",
    "lag": "rvjax.faults.lag",
    "delay": "rvjax.faults.delay",
}
