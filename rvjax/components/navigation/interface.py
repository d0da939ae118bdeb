"""Interface of a navigation error: functions of a sample at an instant; and additive errors of the measurement.

ρ + ε_ρ,   ν + ε_ν,   R(φ/4) R(σ),   ω + ε_ω
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar, Vector, compose


class NavigationError(NamedTuple):
    """see(t, motion, memory, numbers) → the measured motion.

    motion: output of the previous error, or the true motion for the first error. start(motion, numbers) → memory before the first
    step; motion: at t = 0. keep(tick, motion, memory, numbers) → memory of the step that begins at the tick; motion: at that
    instant. The memory is held during the step.
    """

    see: Callable[[Scalar, Motion, Any, Numbers], Motion]
    start: Callable[[Motion, Numbers], Any] = lambda motion, numbers: ()
    keep: Callable[[Tick, Motion, Any, Numbers], Any] = lambda tick, motion, memory, numbers: memory


def displaced(motion: Motion, errors: Mapping[str, Vector]) -> Motion:
    """The motion with the errors that are present; all in P, like sensors on the pursuer.

    position_m [m], velocity_m_s [m/s], rate_rad_s [rad/s] are added. attitude_rad [rad] rotates P about that vector by its
    length, with a relative error of |φ|²/48.
    """
    rho, nu, sigma, omega = motion
    return Motion(
        rho=rho + errors["position_m"] if "position_m" in errors else rho,
        nu=nu + errors["velocity_m_s"] if "velocity_m_s" in errors else nu,
        sigma=compose(errors["attitude_rad"] * 0.25, sigma) if "attitude_rad" in errors else sigma,
        omega=omega + errors["rate_rad_s"] if "rate_rad_s" in errors else omega,
    )
