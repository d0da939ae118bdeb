"""The closed loop: navigation ▸ controller ▸ saturation ▸ faults ▸ (+ disturbances) ▸ dynamics, for one sample at one instant.

ẏ = rate(t, y),   y = (relative motion, target motion, the controller's own state)
u = F(t, h(v)),   total wrench = u + d(t, y)

Faults, disturbances and navigation errors may have a memory, and a controller may be sampled: all of that is renewed where a step
begins and held during the step, so that every stage of the integration sees the same smooth right-hand side.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from rvjax.algebra import Channels, Scalar, Vector, cross, shadow
from rvjax.controllers.interface import Law, Response
from rvjax.disturbances.interface import Disturbance
from rvjax.dynamics import motion_rate, relative, target_alpha, target_rate
from rvjax.faults.interface import Fault
from rvjax.metrics.interface import Rules
from rvjax.navigation.interface import Instrument
from rvjax.saturation import Saturation, saturate
from rvjax.state import Motion, Numbers, Plant, Seen, State, Step, TargetMotion, Tick


class Loop(NamedTuple):
    """Structure: which functions close the loop. Fixed when the flight is compiled.

    sampling: steps between two instants at which the controller looks and commands; 0: it acts continuously.
    """

    law: Law
    saturation: Saturation
    faults: tuple[Fault, ...]
    disturbances: tuple[Disturbance, ...]
    navigation: tuple[Instrument, ...] = ()
    sampling: int = 0


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
    navigation: tuple[Numbers, ...] = ()


class Sampled(NamedTuple):
    """What a sampled controller saw at its last instant, and its command v from then on."""

    seen: Seen
    command: Channels


class Held(NamedTuple):
    """What is renewed where a step begins and held during it: the memories of the components, in the order of the campaign, and
    what a sampled controller goes by (empty where it acts continuously)."""

    faults: tuple[Any, ...]
    disturbances: tuple[Any, ...]
    navigation: tuple[Any, ...]
    control: Sampled | tuple[()]


def start(loop: Loop, drawn: Drawn) -> tuple[State, Held]:
    """y(0): σ by its MRP of norm ≤ 1, the controller started on what it sees; and what is held before the first step begins."""
    motion = drawn.motion._replace(sigma=shadow(drawn.motion.sigma))
    alpha_t = target_alpha(drawn.target.w, drawn.plant.target_inertia, drawn.plant.target_inertia_inverse)
    zero = drawn.plant.upper * 0.0
    navigation = tuple(one.start(motion, own) for one, own in zip(loop.navigation, drawn.navigation, strict=True))
    tick = Tick(0, drawn.rules.step_s * 0.0, drawn.rules.step_s)
    first = measured(loop, drawn, tick.t, motion, renewed(loop, drawn, tick, motion, navigation))
    view = seen(tick.t, first, drawn.target, alpha_t, drawn)
    held = Held(
        faults=tuple(fault.start(zero, own) for fault, own in zip(loop.faults, drawn.faults, strict=True)),
        disturbances=tuple(one.start(own) for one, own in zip(loop.disturbances, drawn.disturbances, strict=True)),
        navigation=navigation,
        control=Sampled(view, zero) if loop.sampling else (),
    )
    return State(motion, drawn.target, loop.law.start(view, drawn.gains)), held


def evaluate(loop: Loop, drawn: Drawn, t: Scalar, y: State, held: Held, tick: Tick | None = None) -> tuple[State, Step, Held]:
    """(ẏ, everything at this instant, what is held). tick: where a step begins, what is held is renewed before it is used."""
    plant = drawn.plant
    alpha_t = target_alpha(y.target.w, plant.target_inertia, plant.target_inertia_inverse)
    if tick is not None:
        held = held._replace(navigation=renewed(loop, drawn, tick, y.motion, held.navigation))
    view = seen(t, measured(loop, drawn, t, y.motion, held.navigation), y.target, alpha_t, drawn)
    actuators = partial(saturate, loop.saturation, upper=plant.upper, lower=plant.lower)
    response, control = commands(loop, drawn, view, y.control, actuators, held.control, tick)

    commanded, _ = actuators(response.command)
    applied, faults = behind_faults(loop, drawn, t, commanded, held.faults, tick)
    known = relative(y.motion, y.target, alpha_t, plant.port)
    disturbance, disturbances = pushes(loop, drawn, t, y, known, held.disturbances, tick)

    moment = applied.torque - cross(plant.centre, applied.force)  # of the same forces, about the centre of mass
    rate = State(
        motion=motion_rate(y.motion, known, plant, Channels(applied.force, moment) + disturbance),
        target=target_rate(y.target, alpha_t),
        control=response.rate,
    )
    step = Step(t, y.motion, view.motion, y.target, plant, response.command, commanded, applied, disturbance, response.report)
    return rate, step, held._replace(faults=faults, disturbances=disturbances, control=control)


def seen(t: Scalar, motion: Motion, target: TargetMotion, alpha_t: Vector, drawn: Drawn) -> Seen:
    """What the controller gets: the measured motion and what a cooperative target sends."""
    return Seen(t, motion, target, alpha_t, drawn.plant.port, drawn.upper, drawn.lower)


def renewed(loop: Loop, drawn: Drawn, tick: Tick, motion: Motion, memories: tuple[Any, ...]) -> tuple[Any, ...]:
    """The memories of the navigation errors for the step that begins."""
    rows = zip(loop.navigation, drawn.navigation, memories, strict=True)
    return tuple(one.keep(tick, motion, memory, own) for one, own, memory in rows)


def measured(loop: Loop, drawn: Drawn, t: Scalar, motion: Motion, memories: tuple[Any, ...]) -> Motion:
    """The motion after every navigation error in turn, in the order of the campaign."""
    for one, own, memory in zip(loop.navigation, drawn.navigation, memories, strict=True):
        motion = one.see(t, motion, memory, own)
    return motion


def commands(
    loop: Loop, drawn: Drawn, view: Seen, own: Any, actuators: Any, control: Sampled | tuple[()], tick: Tick | None
) -> tuple[Response, Sampled | tuple[()]]:
    """The controller's response to what it sees now, or to what it saw at its last instant (zero-order hold).

    Between two instants a sampled controller goes on integrating its own state with the measurement of the last one.
    """
    if not isinstance(control, Sampled):
        return loop.law.respond(view, own, actuators, drawn.gains), control
    due = False if tick is None else tick.k % loop.sampling == 0
    last = jax.tree.map(lambda new, old: jnp.where(due, new, old), view, control.seen)
    response = loop.law.respond(last, own, actuators, drawn.gains)
    command = jax.tree.map(lambda new, old: jnp.where(due, new, old), response.command, control.command)
    return response._replace(command=command), Sampled(last, command)


def behind_faults(
    loop: Loop, drawn: Drawn, t: Scalar, wrench: Channels, memories: tuple[Any, ...], tick: Tick | None
) -> tuple[Channels, tuple[Any, ...]]:
    """The wrench after every fault in turn, in the order of the campaign, and the memories."""
    kept: list[Any] = []
    for fault, own, memory in zip(loop.faults, drawn.faults, memories, strict=True):
        now = memory if tick is None else fault.keep(tick, wrench, memory, own)
        wrench = fault.act(t, wrench, now, drawn.plant.upper, own)
        kept.append(now)
    return wrench, tuple(kept)


def pushes(
    loop: Loop, drawn: Drawn, t: Scalar, y: State, known: Any, memories: tuple[Any, ...], tick: Tick | None
) -> tuple[Channels, tuple[Any, ...]]:
    """The sum of the disturbances, and the memories."""
    total, kept = drawn.plant.upper * 0.0, list[Any]()
    for one, own, memory in zip(loop.disturbances, drawn.disturbances, memories, strict=True):
        now = memory if tick is None else one.keep(tick, y, memory, own)
        total = total + one.push(t, y, known, drawn.plant, now, own)
        kept.append(now)
    return total, tuple(kept)


def between_steps(y: State) -> State:
    """The MRP shadow switch σ → −σ/|σ|² where |σ| > 1: between steps, never inside one."""
    return y._replace(motion=y.motion._replace(sigma=shadow(y.motion.sigma)))
