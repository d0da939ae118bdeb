"""Guidance: where the controller shall be at an instant. A file per member (`rvjax.components.guidance.interface`)."""

from __future__ import annotations

MEMBERS = {
    "direct": "rvjax.components.guidance.direct",
    "corridor": "rvjax.components.guidance.corridor",
    "waypoints": "rvjax.components.guidance.waypoints",
}
