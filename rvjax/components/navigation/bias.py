"""Constant errors of the measurement.

    ρ + b_ρ,   ν + b_ν,   R(b_φ/4) R(σ),   ω + b_ω         all in P, drawn once per sample

Residual errors after calibration: misalignment and offset of sensors. b_φ rotates the measured attitude about an axis of P.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from rvjax.campaign import Model, Quantity, vector
from rvjax.components.effect import zero
from rvjax.components.navigation.interface import NavigationError, displaced
from rvjax.components.registry import Component
from rvjax.physics.state import Motion, Numbers
from rvjax.physics.vectors import Scalar


class Parameters(Model):
    """Error of each quantity. A quantity that is left out has no error."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"position_m": [0.02, 0, 0]},)

    position_m: Quantity | None = vector("m", default=None, doc="error of the position")
    velocity_m_s: Quantity | None = vector("m/s", default=None, doc="error of the velocity")
    attitude_rad: Quantity | None = vector("rad", key="attitude_deg", default=None, doc="error of the attitude, a rotation")
    rate_rad_s: Quantity | None = vector("rad/s", key="rate_deg_s", default=None, doc="error of the angular rate")


def see(t: Scalar, motion: Motion, memory: Any, numbers: Numbers) -> Motion:
    """The motion with its errors."""
    del t, memory
    return displaced(motion, numbers)


NEUTRAL = zero("position_m", "velocity_m_s", "attitude_rad", "rate_rad_s")

COMPONENT = Component(Parameters, lambda parameters: NavigationError(see), neutral=(NEUTRAL,))
