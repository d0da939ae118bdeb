"""Controllers: one file = one member. A component's `build(parameters)` gives a `Law` (`rvjax.controllers.interface`)."""

from __future__ import annotations

MEMBERS = {
    "saturated-adaptive": "rvjax.controllers.saturated_adaptive",
    "pd-plus": "rvjax.controllers.pd_plus",
}
