"""Actuator faults: one file = one member. A component's `build(parameters)` gives a `Fault` (`faults.interface`).

Every fault has an onset per channel and leaves the wrench as it is before it, bit for bit; it may end again, be intermittent, and
befall only some channels of a sample. Faults act one after the other in the order of the campaign.
"""

from __future__ import annotations

MEMBERS = {
    "effectiveness": "rvjax.components.faults.effectiveness",
    "incipient": "rvjax.components.faults.incipient",
    "bias": "rvjax.components.faults.bias",
    "drift": "rvjax.components.faults.drift",
    "stuck": "rvjax.components.faults.stuck",
    "float": "rvjax.components.faults.float",
    "lag": "rvjax.components.faults.lag",
    "delay": "rvjax.components.faults.delay",
}
