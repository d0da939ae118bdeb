"""Navigation errors: one file = one member. A component's `build(parameters)` gives an `NavigationError`
(`rvjax.components.navigation.interface`).

They stand, in the order of the campaign, between the true relative motion and what the controller sees. Without one, navigation
is perfect.
"""

from __future__ import annotations

MEMBERS = {
    "noise": "rvjax.components.navigation.noise",
    "bias": "rvjax.components.navigation.bias",
    "gyro-drift": "rvjax.components.navigation.gyro_drift",
    "delay": "rvjax.components.navigation.delay",
}
