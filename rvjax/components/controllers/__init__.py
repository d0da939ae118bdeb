"""Controllers: a file per member. A component's `build(parameters)` gives a `Controller` (`controllers.interface`)."""

from __future__ import annotations

MEMBERS = {
    "saturated-adaptive": "rvjax.components.controllers.saturated_adaptive",
    "pd-plus": "rvjax.components.controllers.pd_plus",
    "sliding-mode": "rvjax.components.controllers.sliding_mode",
    "nominal-backstepping": "rvjax.components.controllers.nominal_backstepping",
    "anti-windup": "rvjax.components.controllers.anti_windup",
    "command-filtered": "rvjax.components.controllers.command_filtered",
    "disturbance-observer": "rvjax.components.controllers.disturbance_observer",
    "lqr-kalman": "rvjax.components.controllers.lqr_kalman",
}
