"""Constant errors of what is measured.

    ρ + b_ρ,   ν + b_ν,   R(b_φ/4) R(σ),   ω + b_ω         all in P, drawn once a sample

What a calibration leaves: misalignment and offset of sensors. The rotation b_φ turns the measured attitude about an axis of P.
"""

from __future__ import annotations

from typing import Any

from rvjax.campaign import Model, Quantity, vector
from rvjax.components.navigation.interface import NavigationError, displaced
from rvjax.components.registry import Component
from rvjax.physics.state import Motion, Numbers
from rvjax.physics.vectors import Scalar


class Parameters(Model):
    """The error of each quantity; what is left out has none."""

    position_m: Quantity | None = vector("m", default=None, doc="error of the position")
    velocity_m_s: Quantity | None = vector("m/s", default=None, doc="error of the velocity")
    attitude_rad: Quantity | None = vector("rad", key="attitude_deg", default=None, doc="error of the attitude, a rotation")
    rate_rad_s: Quantity | None = vector("rad/s", key="rate_deg_s", default=None, doc="error of the angular rate")


def see(t: Scalar, motion: Motion, memory: Any, numbers: Numbers) -> Motion:
    """The motion, displaced."""
    del t, memory
    return displaced(motion, numbers)


COMPONENT = Component(Parameters, lambda parameters: NavigationError(see))
