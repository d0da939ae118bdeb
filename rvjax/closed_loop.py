"""The closed loop: Seen ▸ controller ▸ saturation ▸ faults ▸ (+ disturbances) ▸ dynamics, for one sample at one instant.

ẏ = rate(t, y),   y = (relative motion, target motion, the controller's own state)
u = F(t, h(v)),   total wrench = u + d(t, y)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

from rvjax.algebra import Channels, Scalar, Vector, shadow
from rvjax.controllers.interface import Law
from rvjax.dynamics import Relative, motion_rate, relative, target_alpha, target_rate
from rvjax.metrics.interface import Rules
from rvjax.saturation import Saturation, saturate
from rvjax.state import Motion, Numbers, Plant, Seen, State, Step, TargetMotion

Fault = Callable[[Scalar, Channels, Plant, Numbers], Channels]
"""(t, wrench, plant, numbers) → wrench behind the fault [N, N·m]."""

Disturbance = Callable[[Scalar, Motion, Relative, Plant, Numbers], Channels]
"""(t, motion, relative geometry, plant, numbers) → disturbance wrench on the pursuer, in P [N, N·m]."""


class Loop(NamedTuple):
    """Structure: which functions close the loop. Fixed when the flight is compiled."""

    law: Law
    saturation: Saturation
    faults: tuple[Fault, ...]
    disturbances: tuple[Disturbance, ...]


class Drawn(NamedTuple):
    """Numbers: everything about one sample. upper, lower: nominal limits, which the controller may know."""

    plant: Plant
    motion: Motion
    target: TargetMotion
    upper: Channels
    lower: Channels
    faults: tuple[Numbers, ...]
    disturbances: tuple[Numbers, ...]
    gains: Numbers
    rules: Rules


def seen(t: Scalar, motion: Motion, target: TargetMotion, alpha_t: Vector, drawn: Drawn) -> Seen:
    """What the controller gets: the true motion (perfect navigation) and what a cooperative target sends."""
    return Seen(t, motion, target, alpha_t, drawn.plant.port, drawn.upper, drawn.lower)


def start(loop: Loop, drawn: Drawn) -> State:
    """y(0): σ by its MRP of norm ≤ 1, the controller started on what it sees."""
    motion = drawn.motion._replace(sigma=shadow(drawn.motion.sigma))
    alpha_t = target_alpha(drawn.target.w, drawn.plant.target_inertia, drawn.plant.target_inertia_inverse)
    return State(motion, drawn.target, loop.law.start(seen(0.0, motion, drawn.target, alpha_t, drawn), drawn.gains))


def evaluate(loop: Loop, drawn: Drawn, t: Scalar, y: State) -> tuple[State, Step]:
    """(ẏ, everything at this instant)."""
    plant = drawn.plant
    alpha_t = target_alpha(y.target.w, plant.target_inertia, plant.target_inertia_inverse)
    actuators = partial(saturate, loop.saturation, upper=plant.upper, lower=plant.lower)
    response = loop.law.respond(seen(t, y.motion, y.target, alpha_t, drawn), y.control, actuators, drawn.gains)

    commanded, _ = actuators(response.command)
    applied = behind_faults(loop.faults, drawn.faults, t, commanded, plant)
    known = relative(y.motion, y.target, alpha_t, plant.port)
    disturbance = commanded * 0.0
    for push, numbers in zip(loop.disturbances, drawn.disturbances, strict=True):
        disturbance = disturbance + push(t, y.motion, known, plant, numbers)

    rate = State(
        motion=motion_rate(y.motion, known, plant, applied + disturbance),
        target=target_rate(y.target, alpha_t),
        control=response.rate,
    )
    return rate, Step(t, y.motion, y.target, plant, response.command, commanded, applied, disturbance, response.report)


def behind_faults(faults: Sequence[Fault], numbers: Sequence[Numbers], t: Scalar, wrench: Channels, plant: Plant) -> Channels:
    """The wrench after every fault in turn, in the order of the campaign."""
    for fault, own in zip(faults, numbers, strict=True):
        wrench = fault(t, wrench, plant, own)
    return wrench


def between_steps(y: State) -> State:
    """The MRP shadow switch σ → −σ/|σ|² where |σ| > 1: between steps, never inside one."""
    return y._replace(motion=y.motion._replace(sigma=shadow(y.motion.sigma)))
