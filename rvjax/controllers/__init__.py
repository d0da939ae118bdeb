"""Controllers: one file = one member. A component's `build(parameters)` gives a `Law` (`rvjax.controllers.interface`)."""

from __future__ import annotations

MEMBERS = {
    "saturated-adaptive": "rvjax.controllers.saturated_adaptive",
    "pd-plus": "rvjax.controllers.pd_plus",
    "sliding-mode": "rvjax.controllers.sliding_mode",
    "nominal-backstepping": "rvjax.controllers.nominal_backstepping",
    "anti-windup": "rvjax.controllers.anti_windup",
    "command-filtered": "rvjax.controllers.command_filtered",
    "disturbance-observer": "rvjax.controllers.disturbance_observer",
}
