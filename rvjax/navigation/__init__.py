"""Navigation errors: one file = one member. A component's `build(parameters)` gives an `Instrument`
(`rvjax.navigation.interface`).

They stand, in the order of the campaign, between the true relative motion and what the controller sees. Without one, navigation
is perfect.
"""

from __future__ import annotations

MEMBERS = {
    "noise": "rvjax.navigation.noise",
    "bias": "rvjax.navigation.bias",
    "gyro-drift": "rvjax.navigation.gyro_drift",
    "delay": "rvjax.navigation.delay",
}
