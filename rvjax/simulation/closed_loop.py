"""The closed loop: navigation ▸ controller ▸ saturation ▸ faults ▸ (+ disturbances) ▸ dynamics, for one sample at one instant.

ẏ = rate(t, y),   y = (relative motion, target motion, the controller's own state)
u = F(t, h(v)),   total wrench = u + d(t, y)
u = B F(t, f),  f = x f_max,  x = allocation(h(v))    where thrusters fly

Thrusts follow the command at every instant, as the six channels do; a controller with a period holds both. The bounded problem
is solved where a step begins and followed from there (`thruster_allocation`). Allocation knows the nominal thrusters: what it
opens is a share x of each, and the drawn largest thrust f_max (modulated valves) and the faults come after it. Behind the faults
too a thrust lies between 0 and f_max: no thruster pulls, none gives more than all.

Faults, disturbances and navigation errors may have a memory, and a controller may be sampled: all of that is renewed where a step
begins and held during the step, so that every stage of the integration sees the same smooth right-hand side.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from rvjax.components.controllers.interface import Controller, Response
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.faults.interface import Fault
from rvjax.components.metrics.interface import MetricContext
from rvjax.components.navigation.interface import NavigationError
from rvjax.physics.dynamics import motion_rate, relative, target_alpha, target_rate
from rvjax.physics.saturation import Saturation, saturate
from rvjax.physics.state import Measurement, Motion, Numbers, Plant, State, Step, TargetMotion, Tick
from rvjax.physics.thruster_allocation import ThrusterSystem
from rvjax.physics.vectors import Channels, Scalar, Thrusts, Vector, cross, each, shadow


class Loop(NamedTuple):
    """Structure: which functions close the loop. Fixed when the flight is compiled.

    sampling: steps between two instants at which the controller looks and commands; 0: it acts continuously. gear: of thrusters,
    where they fly.
    """

    controller: Controller
    saturation: Saturation
    faults: tuple[Fault, ...]
    disturbances: tuple[Disturbance, ...]
    navigation: tuple[NavigationError, ...] = ()
    sampling: int = 0
    gear: ThrusterSystem | None = None


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
    context: MetricContext
    navigation: tuple[Numbers, ...] = ()


class Sampled(NamedTuple):
    """What a sampled controller saw at its last instant, and its command v from then on."""

    t: Scalar
    motion: Motion
    target: TargetMotion
    command: Channels


class Held(NamedTuple):
    """What is renewed where a step begins and held during it: the memories of the components, in the order of the campaign, what
    a sampled controller goes by (empty where it acts continuously), and what the allocation led to there (empty without)."""

    faults: tuple[Any, ...]
    disturbances: tuple[Any, ...]
    navigation: tuple[Any, ...]
    control: Sampled | tuple[()]
    solved: Any = ()


def start(loop: Loop, drawn: Drawn) -> tuple[State, Held]:
    """y(0): σ by its MRP of norm ≤ 1, the controller started on what it sees; and what is held before the first step begins."""
    motion = first = drawn.motion._replace(sigma=shadow(drawn.motion.sigma))
    zero = drawn.plant.upper * 0.0
    idle = able(drawn.plant) * 0.0
    tick = Tick(0, drawn.context.step_s * 0.0, drawn.context.step_s)
    navigation: list[Any] = []
    for one, own in zip(loop.navigation, drawn.navigation, strict=True):
        navigation.append(one.start(first, own))
        first = one.see(tick.t, first, one.keep(tick, first, navigation[-1], own), own)
    held = Held(
        faults=tuple(fault.start(idle, own) for fault, own in zip(loop.faults, drawn.faults, strict=True)),
        disturbances=tuple(one.start(own) for one, own in zip(loop.disturbances, drawn.disturbances, strict=True)),
        navigation=tuple(navigation),
        control=Sampled(tick.t, first, drawn.target, zero) if loop.sampling else (),
        solved=loop.gear.allocation.idle(zero) if loop.gear is not None else (),
    )
    view = measurement(tick.t, first, drawn.target, alpha(drawn.target, drawn.plant), drawn)
    return State(motion, drawn.target, loop.controller.start(view, drawn.gains)), held


def evaluate(loop: Loop, drawn: Drawn, t: Scalar, y: State, held: Held, tick: Tick | None = None) -> tuple[State, Step, Held]:
    """(ẏ, everything at this instant, what is held). tick: where a step begins, what is held is renewed before it is used."""
    plant = drawn.plant
    alpha_t = alpha(y.target, plant)
    motion, navigation = measured(loop, drawn, t, y.motion, held.navigation, tick)
    view = measurement(t, motion, y.target, alpha_t, drawn)
    actuators = partial(saturate, loop.saturation, upper=plant.upper, lower=plant.lower)
    response, control = commands(loop, drawn, view, y.control, actuators, held.control, tick)

    commanded, _ = actuators(response.command)
    applied, thrusts, faults, solved = actuated(loop, drawn, t, commanded, held, tick)
    known = relative(y.motion, y.target, alpha_t, plant.port)
    disturbance, disturbances = pushes(loop, drawn, t, y, known, held.disturbances, tick)

    moment = applied.torque - cross(plant.centre, applied.force)  # of the same forces, about the centre of mass
    rate = State(
        motion=motion_rate(y.motion, known, plant, Channels(applied.force, moment) + disturbance),
        target=target_rate(y.target, alpha_t),
        control=response.rate,
    )
    command = response.command
    step = Step(t, y.motion, motion, y.target, plant, command, commanded, applied, disturbance, response.report, thrusts)
    return rate, step, Held(faults, disturbances, navigation, control, solved)


def alpha(target: TargetMotion, plant: Plant) -> Vector:
    """ω̇_t, in T [rad/s²]."""
    return target_alpha(target.w, plant.target_inertia, plant.target_inertia_inverse)


def measurement(t: Scalar, motion: Motion, target: TargetMotion, alpha_t: Vector, drawn: Drawn) -> Measurement:
    """What the controller gets: the measured motion and what a cooperative target sends."""
    return Measurement(t, motion, target, alpha_t, drawn.plant.port, drawn.upper, drawn.lower)


def measured(
    loop: Loop, drawn: Drawn, t: Scalar, motion: Motion, memories: tuple[Any, ...], tick: Tick | None
) -> tuple[Motion, tuple[Any, ...]]:
    """The motion after every navigation error in turn, in the order of the campaign, and the memories."""
    kept: list[Any] = []
    for one, own, memory in zip(loop.navigation, drawn.navigation, memories, strict=True):
        now = memory if tick is None else one.keep(tick, motion, memory, own)
        motion = one.see(t, motion, now, own)
        kept.append(now)
    return motion, tuple(kept)


def commands(
    loop: Loop, drawn: Drawn, view: Measurement, state: Any, actuators: Any, control: Sampled | tuple[()], tick: Tick | None
) -> tuple[Response, Sampled | tuple[()]]:
    """The controller's response to what it sees now, or to what it saw at its last instant (zero-order hold).

    Between two instants a sampled controller goes on integrating its own state with the measurement of the last one.
    """
    if not isinstance(control, Sampled):
        return loop.controller.respond(view, state, actuators, drawn.gains), control
    due = False if tick is None else tick.k % loop.sampling == 0

    def latest(new: Any, old: Any) -> Any:
        return jax.tree.map(lambda a, b: jnp.where(due, a, b), new, old)

    last = latest(Sampled(view.t, view.motion, view.target, control.command), control)
    last_view = measurement(last.t, last.motion, last.target, alpha(last.target, drawn.plant), drawn)
    response = loop.controller.respond(last_view, state, actuators, drawn.gains)
    command = latest(response.command, control.command)
    return response._replace(command=command), last._replace(command=command)


def able(plant: Plant) -> Any:
    """What every fault takes as the true limit of an actuator: the largest thrusts, or the upper limits of the channels."""
    return plant.thrust if isinstance(plant.thrust, Thrusts) else plant.upper


def actuated(
    loop: Loop, drawn: Drawn, t: Scalar, commanded: Channels, held: Held, tick: Tick | None
) -> tuple[Channels, Thrusts | tuple[()], tuple[Any, ...], Any]:
    """(applied wrench, thrusts behind the faults, memories of the faults, that of the allocation) from the commanded wrench."""
    most = drawn.plant.thrust
    if loop.gear is None or not isinstance(most, Thrusts):
        applied, faults = behind_faults(loop, drawn, t, commanded, held.faults, tick)
        return applied, (), faults, held.solved
    allocation = loop.gear.allocation
    solved = held.solved if tick is None else allocation.solve(commanded)
    opened = allocation.follow(commanded, solved) * most
    failed, faults = behind_faults(loop, drawn, t, opened, held.faults, tick)
    thrusts = each(lambda f, top: jnp.clip(f, 0.0, top), failed, most)
    return loop.gear.wrench(thrusts), thrusts, faults, solved


def behind_faults(
    loop: Loop, drawn: Drawn, t: Scalar, wrench: Any, memories: tuple[Any, ...], tick: Tick | None
) -> tuple[Any, tuple[Any, ...]]:
    """The wrench, or the thrusts, after every fault in turn, in the order of the campaign, and the memories."""
    limit = able(drawn.plant)
    kept: list[Any] = []
    for fault, own, memory in zip(loop.faults, drawn.faults, memories, strict=True):
        now = memory if tick is None else fault.keep(tick, wrench, memory, own)
        wrench = fault.act(t, wrench, now, limit, own)
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
