"""Effects: what moves in or on the pursuer and acts on it, with a continuous state that is integrated with the flight. A file per
member (`rvjax.components.effects.interface`)."""

from __future__ import annotations

MEMBERS = {
    "slosh-pendulum": "rvjax.components.effects.slosh_pendulum",
    "flexible-appendage": "rvjax.components.effects.flexible_appendage",
}
