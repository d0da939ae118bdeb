"""Interface of a navigation error: functions of a sample at an instant; what is known of the target; and additive errors of the
measurement.

ρ + ε_ρ,   ν + ε_ν,   R(φ/4) R(σ),   ω + ε_ω
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rvjax.physics.state import Motion, Numbers, TargetMotion, Tick
from rvjax.physics.vectors import Scalar, Vector, compose


class Known(NamedTuple):
    """What is known of the target, in T: its motion, its angular acceleration ω̇_t [rad/s²], the docking point δ [m]."""

    target: TargetMotion
    alpha_t: Vector
    port: Vector


class NavigationError(NamedTuple):
    """see(t, motion, memory, numbers) → the measured motion.

    motion: output of the previous error, or the true motion for the first error. start(motion, numbers) → memory before the first
    step; motion: at t = 0. keep(tick, motion, memory, numbers) → memory of the step that begins at the tick; motion: at that
    instant. The memory is held during the step.

    knows(t, known, memory, numbers) → what the controller knows of the target; known: output of the previous error, or the truth;
    None: it changes nothing. informed: the numbers of see, start and keep also hold `known`, as it enters. age(t, memory) → time
    since the last measurement [s], a signal of the trace; None: every measurement is new.
    """

    see: Callable[[Scalar, Motion, Any, Numbers], Motion]
    start: Callable[[Motion, Numbers], Any] = lambda motion, numbers: ()
    keep: Callable[[Tick, Motion, Any, Numbers], Any] = lambda tick, motion, memory, numbers: memory
    knows: Callable[[Scalar, Known, Any, Numbers], Known] | None = None
    informed: bool = False
    age: Callable[[Scalar, Any], Scalar] | None = None

    def given(self, numbers: Numbers, known: Known) -> Numbers:
        """The numbers that see, start and keep get."""
        return Numbers({**numbers, "known": known}) if self.informed else numbers


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
