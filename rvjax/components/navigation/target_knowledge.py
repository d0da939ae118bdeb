"""What the controller knows of the target is not exact: rate, attitude and docking point, constant errors drawn once per sample.

    ω_t → R(φ/4) ω_t + b,   ω̇_t, r_t, v_t → R(φ/4) (…)                  φ: attitude, b: rate
    δ → δ + e,   ρ → ρ − R(σ) e,   ν → ν − R(σ) (ω_t×e)                 e: docking point

The controller takes the target's data as resolved in T, but they are resolved in axes turned by φ. It believes that the docking
point is at δ + e, and measures ρ and ν relative to that point, so it flies to ρ = R(σ) e. ω̇_t has no error beside the rotation.
φ, b and e are in T; the rotation has a relative error of |φ|²/48. White noise on the rate: `target-noise`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from rvjax.campaign import Model, Quantity, vector
from rvjax.components.effect import zero
from rvjax.components.navigation.interface import Known, NavigationError
from rvjax.components.registry import Component
from rvjax.physics.state import Motion, Numbers, TargetMotion
from rvjax.physics.vectors import Scalar, cross, rotate, rotation


class Parameters(Model):
    """Error of each quantity. A quantity that is left out is known exactly."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"rate_deg_s": {"box": 0.02}, "attitude_deg": {"ball": 1.0}, "port_m": {"ball": 0.02}},
    )

    rate_rad_s: Quantity | None = vector("rad/s", key="rate_deg_s", default=None, doc="error b of the target's angular rate")
    attitude_rad: Quantity | None = vector(
        "rad", key="attitude_deg", default=None, doc="error φ of the target's attitude, a rotation"
    )
    port_m: Quantity | None = vector("m", default=None, doc="error e of the docking point")


def see(t: Scalar, motion: Motion, memory: Any, numbers: Numbers) -> Motion:
    """The motion relative to the point that is taken for the docking point."""
    del t, memory
    if "port_m" not in numbers:
        return motion
    turn, error = rotation(motion.sigma), numbers.port_m
    swing = cross(numbers.known.target.w, error)
    return motion._replace(rho=motion.rho - rotate(turn, error), nu=motion.nu - rotate(turn, swing))


def knows(t: Scalar, known: Known, memory: Any, numbers: Numbers) -> Known:
    """The target's data with their errors."""
    del t, memory
    (r, v, w), alpha_t, port = known
    if "attitude_rad" in numbers:
        turn = rotation(numbers.attitude_rad * 0.25)
        r, v, w, alpha_t = (rotate(turn, x) for x in (r, v, w, alpha_t))
    w = w + numbers.rate_rad_s if "rate_rad_s" in numbers else w
    return Known(TargetMotion(r, v, w), alpha_t, port + numbers.port_m if "port_m" in numbers else port)


NEUTRAL = zero("rate_rad_s", "attitude_rad", "port_m")

COMPONENT = Component(
    Parameters, lambda parameters: NavigationError(see, knows=knows, informed=parameters.port_m is not None), neutral=(NEUTRAL,)
)
