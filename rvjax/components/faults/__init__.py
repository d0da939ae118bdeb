"""Actuator faults: a file per member. A component's `build(parameters)` gives a `Fault` (`faults.interface`).

Every fault has an onset per channel and does not change the wrench before it, bit for bit. It may end, be intermittent, and
affect only some channels of a sample. Faults act in series, in the order of the campaign.
"""

from __future__ import annotations

MEMBERS = {
    "effectiveness": "rvjax.components.faults.effectiveness",
    "incipient": "rvjax.components.faults.incipient",
    "bias": "rvjax.components.faults.bias",
    "drift": "rvjax.components.faults.drift",
    "stuck": "rvjax.components.faults.stuck",
    "float": "rvjax.components.faults.float",
    "reversed": "rvjax.components.faults.reversed",
    "lag": "rvjax.components.faults.lag",
    "delay": "rvjax.components.faults.delay",
}
