"""Navigation errors: a file per member. A component's `build(parameters)` gives a `NavigationError`
(`rvjax.components.navigation.interface`).

They act in the order of the campaign, between the true relative motion and the controller. Without them, navigation is perfect.
"""

from __future__ import annotations

MEMBERS = {
    "noise": "rvjax.components.navigation.noise",
    "bias": "rvjax.components.navigation.bias",
    "gyro-drift": "rvjax.components.navigation.gyro_drift",
    "delay": "rvjax.components.navigation.delay",
    "update-rate": "rvjax.components.navigation.update_rate",
    "dropouts": "rvjax.components.navigation.dropouts",
    "outage": "rvjax.components.navigation.outage",
    "target-knowledge": "rvjax.components.navigation.target_knowledge",
    "target-noise": "rvjax.components.navigation.target_noise",
}
