"""The last measurement while there is no new one: held, or propagated without forces.

    hold        ρ, ν, σ, ω of the last measurement
    propagate   ρ̇ = ν − Ω×ρ,   ν̇ = −Ω×ν,   σ̇ = G(σ) ω,   ω̇ = 0,        Ω = ω + R(σ) ω_t

From step to step, with Ω, ν and ω of the beginning of the step: the last ones, or what is measured there. Gravity and thrust
change ν, but the sensor does not know them. In a step the rotation of P is R(Ωh/4), exact to (Ωh)³/48.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import jax.numpy as jnp
from pydantic import field_validator

from rvjax.campaign import Model, option
from rvjax.campaign.problems import Problem, refuse
from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar, Vector, compose, each, rotate, rotation, shadow

QUANTITIES = {"position": "rho", "velocity": "nu", "attitude": "sigma", "rate": "omega"}
"""Word in a campaign → part of the motion."""

Quantities = Literal["position", "velocity", "attitude", "rate"]


class Interrupted(Model):
    """What a measurement that is not always new has in common."""

    of: tuple[Quantities, ...] = option(
        default=[*QUANTITIES], example=["position", "velocity", "attitude"], doc="measured quantities that it concerns"
    )
    between: Literal["hold", "propagate"] = option(
        default="hold", doc="without a new measurement: the last one, or the last one propagated without forces"
    )

    @field_validator("of")
    @classmethod
    def _each_once(cls, of: tuple[Quantities, ...]) -> tuple[Quantities, ...]:
        """In the order of the motion."""
        if not of:
            refuse(Problem("an empty list", f"accepted: some of {', '.join(QUANTITIES)}"))
        twice = [(index, name) for index, name in enumerate(of) if name in of[:index]]
        if twice:
            refuse(*(Problem(f"{name} is listed twice", "accepted: each once", (index,)) for index, name in twice))
        return tuple(name for name in QUANTITIES if name in of)  # pyright: ignore[reportReturnType]


class Last(NamedTuple):
    """measured_s: time of the last measurement [s]. motion: held or propagated to the beginning of this step. begin_s: of this
    step [s]; turning: Ω there [rad/s]; both empty where it is held."""

    measured_s: Scalar
    motion: Motion
    begin_s: Scalar | tuple[()] = ()
    turning: Vector | tuple[()] = ()


class LastMeasurement(NamedTuple):
    """The rule: parts of the motion that are not always new, and whether the last ones are propagated."""

    parts: tuple[str, ...]
    propagated: bool

    @classmethod
    def of(cls, parameters: Interrupted) -> LastMeasurement:
        """The rule that a campaign chooses."""
        return cls(tuple(QUANTITIES[name] for name in parameters.of), parameters.between == "propagate")

    def first(self, motion: Motion, numbers: Numbers) -> Last:
        """The measurement at t = 0."""
        zero = motion.rho.x * 0.0
        return self._at(zero, motion, zero, numbers)

    def renewed(self, new: Scalar, tick: Tick, motion: Motion, last: Last, numbers: Numbers) -> Last:
        """At the beginning of a step. new: whether it is measured there; motion: the measurement."""
        before = advanced(last.motion, last.turning, tick.t - last.begin_s) if isinstance(last.turning, Vector) else last.motion
        latest = each_part(lambda a, b: jnp.where(new, a, b), motion, before)
        return self._at(jnp.where(new, tick.t, last.measured_s), self._merged(latest, motion), tick.t, numbers)

    def seen(self, t: Scalar, motion: Motion, last: Last) -> Motion:
        """The measured motion in a step."""
        now = advanced(last.motion, last.turning, t - last.begin_s) if isinstance(last.turning, Vector) else last.motion
        return self._merged(now, motion)

    def _merged(self, last: Motion, motion: Motion) -> Motion:
        """The parts that this concerns from `last`, the others from the motion."""
        return motion._replace(**{name: getattr(last, name) for name in self.parts})

    def _at(self, measured_s: Scalar, motion: Motion, begin_s: Scalar, numbers: Numbers) -> Last:
        if not self.propagated:
            return Last(measured_s, motion)
        turning = motion.omega + rotate(rotation(motion.sigma), numbers.known.target.w)
        return Last(measured_s, motion, begin_s, turning)


def each_part(f: Any, *motions: Motion) -> Motion:
    """f of the components of motions."""
    return Motion(*(each(f, *parts) for parts in zip(*motions, strict=True)))


def advanced(motion: Motion, turning: Vector, dt: Scalar) -> Motion:
    """The motion after a time dt without forces; turning: Ω [rad/s]."""
    frame = rotation(turning * (0.25 * dt))
    return Motion(
        rho=rotate(frame, motion.rho + motion.nu * dt),
        nu=rotate(frame, motion.nu),
        sigma=shadow(compose(motion.omega * (0.25 * dt), motion.sigma)),
        omega=motion.omega,
    )


def age(t: Scalar, last: Last) -> Scalar:
    """Time since the last measurement [s]."""
    return t - last.measured_s
