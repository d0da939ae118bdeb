"""Saturations: how a command is limited to what the actuators can give. A file per member; `build(parameters)` gives a function
(v, u⁺, u⁻) → (h, h') of a channel (`rvjax.physics.saturation`)."""

from __future__ import annotations

MEMBERS = {
    "smooth-tanh": "rvjax.components.saturations.smooth_tanh",
    "shifted-tanh": "rvjax.components.saturations.shifted_tanh",
    "erf": "rvjax.components.saturations.erf",
    "hard-clip": "rvjax.components.saturations.hard_clip",
}
