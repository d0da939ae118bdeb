"""The closed loop: navigation ▸ guidance ▸ controller ▸ saturation ▸ actuators ▸ faults ▸ (+ disturbances, effects) ▸ dynamics,
of a single sample at a single instant.

ẏ = rate(t, y),   y = (relative motion, target motion, state of the controller)
u = F(t, h(v)),   total wrench = u + d(t, y)
u = B F(t, f),  f = x f_max,  x = allocation(h(v))    with thrusters

Thrusts follow the command at every instant, as the six channels do. A controller with a period holds both. The bounded problem
is solved at the start of a step; within the step its solution is updated (`thruster_allocation`). The allocation knows only the
nominal thrusters: it opens each by a share x. The drawn largest thrust f_max (modulated valves) and the faults come after it.
After the faults too a thrust lies between 0 and f_max.

With propellant (`rvjax.physics.propellant`) ṁ_c is a part of ẏ, and mass, inertia and centre of mass are those of the instant.

Faults, disturbances, navigation errors and the guidance may have a memory, and a controller may be sampled. All of this is
updated at the start of a step and held during the step, so every stage of the integration sees the same smooth right-hand side.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from rvjax.components.actuators.interface import Actuator, Limits
from rvjax.components.controllers.interface import Controller, DiscreteController, Response
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.effects.interface import Effect
from rvjax.components.faults.interface import Fault
from rvjax.components.guidance import interface as guidance
from rvjax.components.guidance.interface import Guidance, Guided, Situation
from rvjax.components.metrics.interface import MetricContext
from rvjax.components.navigation.interface import Known, NavigationError
from rvjax.physics.dynamics import motion_rate, relative, target_alpha, target_rate
from rvjax.physics.propellant import Propellant, feeds, flow, level, lighter, supplied
from rvjax.physics.saturation import Saturation, saturate
from rvjax.physics.state import Measurement, Motion, Numbers, Plant, State, Step, Tank, TargetMotion, Tick
from rvjax.physics.thruster_allocation import ThrusterSystem
from rvjax.physics.vectors import Channels, Scalar, Thrusts, Vector, cross, each, shadow
from rvjax.simulation.effects_sum import effects_sum


class Loop(NamedTuple):
    """Structure: the functions that close the loop. Fixed when the flight is compiled.

    sampling: steps between two instants of a sampled or discrete-time controller; 0: it is continuous. gear: the thrusters, None
    without them. guidance: None where the controller regulates to the docking point.
    """

    controller: Controller | DiscreteController
    saturation: Saturation
    faults: tuple[Fault, ...]
    disturbances: tuple[Disturbance, ...]
    navigation: tuple[NavigationError, ...] = ()
    sampling: int = 0
    actuation: tuple[Actuator, ...] = ()
    effects: tuple[Effect, ...] = ()
    gear: ThrusterSystem | None = None
    guidance: Guidance | None = None


class Drawn(NamedTuple):
    """Numbers: all drawn values of a sample. plant: at t = 0. upper, lower: nominal limits, which the controller may know.
    propellant: empty in a campaign without."""

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
    actuation: tuple[Numbers, ...] = ()
    effects: tuple[Numbers, ...] = ()
    propellant: Propellant | tuple[()] = ()
    guidance: Numbers = Numbers({})


class Sampled(NamedTuple):
    """The measurement of a sampled controller at its last instant, and its command v since then."""

    view: Measurement
    command: Channels


class Discrete(NamedTuple):
    """State, command and report of a discrete-time controller since its last instant."""

    state: Any
    command: Channels
    report: Any


class Held(NamedTuple):
    """Values that are updated at the start of a step and held during it.

    faults, disturbances, navigation, actuation: memories of the components, in the order of the campaign; guidance: of the
    guidance, empty without. control: the last sample of a sampled or discrete-time controller, empty if it is continuous. solved:
    the solution of the allocation, empty without thrusters. fed: 1 while there is propellant, else 0; empty in a campaign without
    propellant."""

    faults: tuple[Any, ...]
    disturbances: tuple[Any, ...]
    navigation: tuple[Any, ...]
    control: Sampled | Discrete | tuple[()]
    solved: Any = ()
    actuation: tuple[Any, ...] = ()
    fed: Scalar | tuple[()] = ()
    guidance: Guided | tuple[()] = ()


def start(loop: Loop, drawn: Drawn) -> tuple[State, Held]:
    """y(0) with |σ| ≤ 1 and the controller started on its first measurement; the held values before the first step."""
    motion = first = drawn.motion._replace(sigma=shadow(drawn.motion.sigma))
    zero = drawn.plant.upper * 0.0
    idle = true_limits(drawn.plant) * 0.0
    tick = Tick(0, drawn.context.step_s * 0.0, drawn.context.step_s)
    navigation: list[Any] = []
    known = Known(drawn.target, alpha(drawn.target, drawn.plant), drawn.plant.port)
    for error, numbers in zip(loop.navigation, drawn.navigation, strict=True):
        navigation.append(error.start(first, error.given(numbers, known)))
        first, known, _ = through(error, tick.t, first, known, navigation[-1], numbers, tick=tick)
    view = measurement(tick.t, first, known.target, known.alpha_t, drawn, known.port)
    guided: Guided | tuple[()] = ()
    if loop.guidance is not None:
        guided = guidance.started(loop.guidance, situation(view, drawn), drawn.guidance)
        view = guidance.followed(view, guided.path)
    integrated = loop.controller.start(view, drawn.gains)
    sample: Sampled | Discrete | tuple[()] = Sampled(view, zero) if loop.sampling else ()
    if isinstance(loop.controller, DiscreteController):
        integrated, sample = (), _before_its_first_instant(loop.controller, loop, drawn, view, integrated)
    consumed = drawn.context.step_s * 0.0 if isinstance(drawn.propellant, Propellant) else ()
    held = Held(
        faults=tuple(fault.start(idle, numbers) for fault, numbers in zip(loop.faults, drawn.faults, strict=True)),
        disturbances=tuple(d.start(numbers) for d, numbers in zip(loop.disturbances, drawn.disturbances, strict=True)),
        navigation=tuple(navigation),
        control=sample,
        solved=loop.gear.allocation.idle(zero) if loop.gear is not None else (),
        actuation=tuple(actuator.start(idle, numbers) for actuator, numbers in zip(loop.actuation, drawn.actuation, strict=True)),
        fed=feeds(drawn.propellant, consumed) if isinstance(drawn.propellant, Propellant) else (),
        guidance=guided,
    )
    effects = tuple(effect.start(numbers) for effect, numbers in zip(loop.effects, drawn.effects, strict=True))
    return State(motion, drawn.target, integrated, effects, consumed), held


def evaluate(loop: Loop, drawn: Drawn, t: Scalar, y: State, held: Held, tick: Tick | None = None) -> tuple[State, Step, Held]:
    """(ẏ, the step at this instant, held values). tick: at the start of a step; the held values are then updated before use."""
    plant, tank, fed = present(drawn, y.consumed, held.fed, tick)
    alpha_t = alpha(y.target, plant)
    truth = Known(y.target, alpha_t, plant.port)
    motion, told, navigation = measured(loop, drawn, t, y.motion, truth, held.navigation, tick=tick)
    seen = measurement(t, motion, told.target, told.alpha_t, drawn, told.port)
    view, guided = referred(loop, drawn, seen, held.guidance, tick)
    actuators = partial(saturate, loop.saturation, upper=plant.upper, lower=plant.lower)
    response, control = commands(loop, drawn, view, y.control, actuators, held.control, tick=tick)

    commanded, _ = actuators(response.command)
    applied, thrusts, acted = actuated(loop, drawn, t, commanded, held, tick)
    burning: Scalar | tuple[()] = ()
    if isinstance(drawn.propellant, Propellant):
        applied, thrusts = supplied(drawn.propellant, fed, applied, thrusts)
        burning = flow(drawn.propellant, applied, thrusts)
    known = relative(y.motion, y.target, alpha_t, plant.port)
    disturbance, disturbances = disturbance_sum(loop, drawn, t, y, known, plant, held.disturbances, tick=tick)

    moment = applied.torque - cross(plant.centre, applied.force)  # about the centre of mass
    wrench = Channels(applied.force, moment) + disturbance
    wrench, rates, signals = effects_sum(loop.effects, drawn.effects, y.effects, t, known, plant, wrench)
    rate = State(
        motion=motion_rate(y.motion, known, plant, wrench),
        target=target_rate(y.target, alpha_t),
        control=response.rate,
        effects=rates,
        consumed=burning,
    )
    command = response.command
    step = Step(t, y.motion, motion, y.target, plant, command, commanded, applied, disturbance, response.report, thrusts)
    path = guided.path.at(t) if isinstance(guided, Guided) else ()
    step = step._replace(effects=tuple(zip(y.effects, signals, strict=True)), tank=tank, total=wrench)
    step = step._replace(ages=ages(loop, t, navigation), path=path)
    kept = {"disturbances": disturbances, "navigation": navigation, "control": control, "fed": fed, "guidance": guided}
    return rate, step, acted._replace(**kept)


def present(
    drawn: Drawn, consumed: Scalar | tuple[()], fed: Scalar | tuple[()], tick: Tick | None
) -> tuple[Plant, Tank | tuple[()], Scalar | tuple[()]]:
    """(plant of the instant, what is in its tank, whether its actuators are fed)."""
    if not isinstance(drawn.propellant, Propellant):
        return drawn.plant, (), fed
    tank = level(drawn.propellant, consumed)
    fed = fed if tick is None else feeds(drawn.propellant, consumed)
    return lighter(drawn.plant, drawn.propellant, tank.used), tank, fed


def alpha(target: TargetMotion, plant: Plant) -> Vector:
    """ω̇_t, in T [rad/s²]."""
    return target_alpha(target.w, plant.target_inertia, plant.target_inertia_inverse)


def measurement(
    t: Scalar, motion: Motion, target: TargetMotion, alpha_t: Vector, drawn: Drawn, port: Vector | None = None
) -> Measurement:
    """The input of the controller: the measured motion and the data that a cooperative target sends. port: None: δ."""
    return Measurement(t, motion, target, alpha_t, drawn.plant.port if port is None else port, drawn.upper, drawn.lower)


def measured(
    loop: Loop, drawn: Drawn, t: Scalar, motion: Motion, known: Known, memories: tuple[Any, ...], *, tick: Tick | None
) -> tuple[Motion, Known, tuple[Any, ...]]:
    """The motion and what is known of the target after every navigation error in turn, in the order of the campaign, and the
    memories. known: the truth."""
    kept: list[Any] = []
    for error, numbers, memory in zip(loop.navigation, drawn.navigation, memories, strict=True):
        motion, known, now = through(error, t, motion, known, memory, numbers, tick=tick)
        kept.append(now)
    return motion, known, tuple(kept)


def through(
    error: NavigationError, t: Scalar, motion: Motion, known: Known, memory: Any, numbers: Numbers, *, tick: Tick | None
) -> tuple[Motion, Known, Any]:
    """The motion and what is known of the target after a navigation error, and its memory."""
    given = error.given(numbers, known)
    now = memory if tick is None else error.keep(tick, motion, memory, given)
    told = known if error.knows is None else error.knows(t, known, now, numbers)
    return error.see(t, motion, now, given), told, now


def ages(loop: Loop, t: Scalar, memories: tuple[Any, ...]) -> tuple[Scalar, ...]:
    """Time since the last measurement [s], of each navigation error that has it."""
    pairs = zip(loop.navigation, memories, strict=True)
    return tuple(error.age(t, memory) for error, memory in pairs if error.age is not None)


def situation(view: Measurement, drawn: Drawn) -> Situation:
    """What the guidance knows: the measurement relative to the docking point, and the docking axis."""
    return Situation(view.t, view.motion, view.target, view.alpha_t, view.port, drawn.context.axis)


def referred(
    loop: Loop, drawn: Drawn, view: Measurement, memory: Guided | tuple[()], tick: Tick | None
) -> tuple[Measurement, Guided | tuple[()]]:
    """The measurement relative to the reference point of the guidance, and the memory; without guidance as they are."""
    if loop.guidance is None or not isinstance(memory, Guided):
        return view, memory
    if tick is not None:
        memory = guidance.kept(loop.guidance, tick, situation(view, drawn), memory, drawn.guidance)
    return guidance.followed(view, memory.path.at(view.t)), memory


def _before_its_first_instant(
    controller: DiscreteController, loop: Loop, drawn: Drawn, view: Measurement, state: Any
) -> Discrete:
    """A discrete-time controller before t = 0: its state, and zeros in the form of its command and report."""
    actuators = partial(saturate, loop.saturation, upper=drawn.plant.upper, lower=drawn.plant.lower)
    command, _, report = controller.update(view, state, actuators, drawn.gains)
    return Discrete(state, *jax.tree.map(lambda x: x * 0.0, (command, report)))


def commands(
    loop: Loop,
    drawn: Drawn,
    view: Measurement,
    state: Any,
    actuators: Any,
    control: Sampled | Discrete | tuple[()],
    *,
    tick: Tick | None,
) -> tuple[Response, Sampled | Discrete | tuple[()]]:
    """The controller's response to the present measurement, or to that of its last instant (zero-order hold).

    Between two instants a sampled controller integrates its state with the last measurement; a discrete-time controller has no
    state that is integrated.
    """
    controller = loop.controller
    if isinstance(controller, DiscreteController):
        assert isinstance(control, Discrete)
        held: Discrete = control
        if tick is not None:
            due = tick.k % loop.sampling == 0
            held = jax.lax.cond(due, partial(_updated, controller, drawn, view, actuators), lambda held: held, held)
        return Response(held.command, state, held.report), held
    if not isinstance(control, Sampled):
        return controller.respond(view, state, actuators, drawn.gains), control
    due = False if tick is None else tick.k % loop.sampling == 0

    def latest(new: Any, old: Any) -> Any:
        return jax.tree.map(lambda a, b: jnp.where(due, a, b), new, old)

    last = latest(Sampled(view, control.command), control)
    response = controller.respond(last.view, state, actuators, drawn.gains)
    command = latest(response.command, control.command)
    return response._replace(command=command), last._replace(command=command)


def _updated(controller: DiscreteController, drawn: Drawn, view: Measurement, actuators: Any, held: Discrete) -> Discrete:
    """A discrete-time controller after an instant, in the types of before."""
    command, state, report = controller.update(view, held.state, actuators, drawn.gains)
    return jax.tree.map(lambda new, old: jnp.asarray(new, jnp.result_type(old)), Discrete(state, command, report), held)


def true_limits(plant: Plant) -> Any:
    """The true limits of the actuators: the largest thrusts, or the upper limits of the channels."""
    return plant.thrust if isinstance(plant.thrust, Thrusts) else plant.upper


def actuated(
    loop: Loop, drawn: Drawn, t: Scalar, commanded: Channels, held: Held, tick: Tick | None
) -> tuple[Channels, Thrusts | tuple[()], Held]:
    """(applied wrench, thrusts after the faults, held values with the memories of actuators and faults and the allocation)."""
    most = drawn.plant.thrust
    if loop.gear is None or not isinstance(most, Thrusts):
        driven, actuation = after_actuators(loop, drawn, t, commanded, held.actuation, tick)
        applied, faults = after_faults(loop, drawn, t, driven, held.faults, tick)
        return applied, (), held._replace(faults=faults, actuation=actuation)
    allocation = loop.gear.allocation
    solved = held.solved if tick is None else allocation.solve(commanded)
    opened = allocation.follow(commanded, solved) * most
    driven, actuation = after_actuators(loop, drawn, t, opened, held.actuation, tick)
    failed, faults = after_faults(loop, drawn, t, driven, held.faults, tick)
    thrusts = each(lambda f, top: jnp.clip(f, 0.0, top), failed, most)
    return loop.gear.wrench(thrusts), thrusts, held._replace(faults=faults, actuation=actuation, solved=solved)


def after_actuators(
    loop: Loop, drawn: Drawn, t: Scalar, wrench: Any, memories: tuple[Any, ...], tick: Tick | None
) -> tuple[Any, tuple[Any, ...]]:
    """The wrench, or the thrusts, after every actuator in turn, in the order of the campaign, and the memories."""
    upper = true_limits(drawn.plant)
    limits = Limits(upper, upper * 0.0 if isinstance(upper, Thrusts) else drawn.plant.lower)
    kept: list[Any] = []
    for actuator, numbers, memory in zip(loop.actuation, drawn.actuation, memories, strict=True):
        now = memory if tick is None else actuator.keep(tick, wrench, memory, limits, numbers)
        wrench = actuator.act(t, wrench, now, limits, numbers)
        kept.append(now)
    return wrench, tuple(kept)


def after_faults(
    loop: Loop, drawn: Drawn, t: Scalar, wrench: Any, memories: tuple[Any, ...], tick: Tick | None
) -> tuple[Any, tuple[Any, ...]]:
    """The wrench, or the thrusts, after every fault in turn, in the order of the campaign, and the memories."""
    limit = true_limits(drawn.plant)
    kept: list[Any] = []
    for fault, numbers, memory in zip(loop.faults, drawn.faults, memories, strict=True):
        now = memory if tick is None else fault.keep(tick, wrench, memory, numbers)
        wrench = fault.act(t, wrench, now, limit, numbers)
        kept.append(now)
    return wrench, tuple(kept)


def disturbance_sum(
    loop: Loop, drawn: Drawn, t: Scalar, y: State, known: Any, plant: Plant, memories: tuple[Any, ...], *, tick: Tick | None
) -> tuple[Channels, tuple[Any, ...]]:
    """The sum of the disturbances on the plant of the instant, and the memories."""
    total, kept = drawn.plant.upper * 0.0, list[Any]()
    for disturbance, numbers, memory in zip(loop.disturbances, drawn.disturbances, memories, strict=True):
        now = memory if tick is None else disturbance.keep(tick, y, memory, numbers)
        total = total + disturbance.push(t, y, known, plant, now, numbers)
        kept.append(now)
    return total, tuple(kept)


def between_steps(y: State) -> State:
    """The MRP shadow switch σ → −σ/|σ|² where |σ| > 1: between steps, never within a step."""
    return y._replace(motion=y.motion._replace(sigma=shadow(y.motion.sigma)))
