"""Interface of a guidance: a reference point p(t) that moves in the target's frame T; the controller follows it.

    ρ_c = ρ − R p,   ν_c = ν − R (ω_t×p + ṗ)                        what the controller gets in the place of ρ and ν
    p(t) = p_k + ṗ_k τ + ½ p̈_k τ²,   τ = t − t_k                     within a step; p and ṗ are continuous
    p̈_k = b + 2 c×u' + c×(c×q) + ċ×q,   b = (u − u')/T, of length a at most
    u' = ṗ − c×q,   q = δ + p

A guidance says the wanted velocity u, in a frame of its choice about the target's centre that turns with c relative to T (c = 0:
T itself). u': velocity of the point in this frame, b: its acceleration there, T: time constant, a: largest acceleration. p: from
the docking point δ; all in T. The point starts where the pursuer is measured at t = 0, and with its velocity.

The controller sees p, ṗ and p̈ of the present instant and nothing of the future.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, scalar
from rvjax.campaign.plain_values import Place
from rvjax.physics.orbit_frame import Turning
from rvjax.physics.state import Measurement, Motion, Numbers, Path, PointMotion, TargetMotion, Tick
from rvjax.physics.vectors import Scalar, Vector, cross, dot, rotate, rotate_back, rotation

STEPS = 2.0
"""The shortest time constant, in steps: with less than one the velocity swings from step to step."""

Need = Literal["axis", "orbit"]
"""What a guidance may ask of a target: a docking axis, a stated orbit."""


class GuidanceParameters(Model):
    """How the reference point speeds up and brakes."""

    acceleration: Quantity = scalar("m/s²", default=0.02, above=0.0, doc="largest acceleration a of the reference point")
    time_constant_s: Quantity = scalar("s", default=1.0, above=0.0, doc="time constant T of its velocity, 2 steps at least")


class Situation(NamedTuple):
    """What a guidance knows at the start of a step: the measured motion relative to the docking point δ (port), the data on the
    target, its angular acceleration, and the docking axis, all of the target in T."""

    t: Scalar
    motion: Motion
    target: TargetMotion
    alpha_t: Vector
    port: Vector
    axis: Vector


class Wanted(NamedTuple):
    """velocity: u, resolved in T [m/s]; turning: of the frame that u is relative to; kept: the member's memory."""

    velocity: Vector
    turning: Turning
    kept: Any = ()


class Guided(NamedTuple):
    """The memory of a guidance: the path, and what the member keeps."""

    path: Path
    kept: Any = ()


class Guidance(NamedTuple):
    """wanted(situation, path, kept, numbers) → `Wanted`. path: at this instant. numbers: also those of `GuidanceParameters`.

    start(situation, path, numbers) → kept before the first step. needs: what a target must have, each with the place in the
    parameters that asks for it.
    """

    wanted: Callable[[Situation, Path, Any, Numbers], Wanted]
    start: Callable[[Situation, Path, Numbers], Any] = lambda situation, path, numbers: ()
    needs: tuple[tuple[Place, Need], ...] = ()


def started(guidance: Guidance, situation: Situation, numbers: Numbers) -> Guided:
    """Before the first step: the point is at the pursuer and moves with it."""
    r = rotation(situation.motion.sigma)
    point = rotate_back(r, situation.motion.rho)
    velocity = rotate_back(r, situation.motion.nu) - cross(situation.target.w, point)
    path = Path(situation.t, point, velocity, point * 0.0)
    return Guided(path, guidance.start(situation, path, numbers))


def kept(guidance: Guidance, tick: Tick, situation: Situation, memory: Guided, numbers: Numbers) -> Guided:
    """The memory of the step that begins at the tick."""
    path = memory.path.at(tick.t)
    wanted = guidance.wanted(situation, path, memory.kept, numbers)
    (c, swing), q = wanted.turning, situation.port + path.point
    carried = cross(c, q)
    relative = path.velocity - carried
    b = limited((wanted.velocity - relative) * (1.0 / numbers.time_constant_s), numbers.acceleration)
    accel = b + cross(c, relative * 2.0 + carried) + cross(swing, q)
    return Guided(path._replace(accel=accel), wanted.kept)


def followed(measurement: Measurement, path: Path) -> Measurement:
    """The measurement relative to the reference point at this instant."""
    motion, target = measurement.motion, measurement.target
    r = rotation(motion.sigma)
    carried = cross(target.w, path.point) + path.velocity
    relative = motion._replace(rho=motion.rho - rotate(r, path.point), nu=motion.nu - rotate(r, carried))
    moving = PointMotion(path.velocity, path.accel)
    return measurement._replace(motion=relative, port=measurement.port + path.point, moving=moving)


def in_target(situation: Situation) -> Vector:
    """Where the pursuer is: Rᵀρ, from the docking point, in T [m]."""
    return rotate_back(rotation(situation.motion.sigma), situation.motion.rho)


def length(a: Vector) -> Scalar:
    """|a|, and 1 pm for less: safe to divide by."""
    return jnp.sqrt(jnp.maximum(dot(a, a), 1e-24))


def limited(a: Vector, most: Scalar) -> Vector:
    """a, or the vector of length `most` > 0 in its direction."""
    return a * (most / jnp.sqrt(jnp.maximum(dot(a, a), most * most)))


def granted(error: Vector, accepted: Scalar) -> Scalar:
    """1 for an error up to the accepted size, 0 from twice the size on, linear between them."""
    return jnp.maximum(2.0 - jnp.sqrt(jnp.maximum(dot(error, error) * (1.0 / (accepted * accepted)), 1.0)), 0.0)


def brakes(speed: Scalar, numbers: Numbers) -> tuple[Scalar, Scalar]:
    """(κ', v'): slope and largest speed with which the point stops without passing its goal.

    κ' = min(κ, 1/(4T)): on v = κ'x with the time constant T it does not swing;   v' = min(v, a/κ'): it brakes by κ'v' at most
    """
    slope = jnp.minimum(numbers.slope, 0.25 / numbers.time_constant_s)
    return slope, jnp.minimum(speed, numbers.acceleration / slope)
