"""Checks of a user's component before it flies: JAX traces it with shapes instead of numbers.

A trace finds errors, wrong kinds and shapes of what comes back, and numbers of the campaign that nothing depends on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, Literal, NamedTuple, get_args, get_origin

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend import core as jaxpr_core

from rvjax.campaign import Model, Quantity
from rvjax.campaign.python_files import PythonFile
from rvjax.campaign.thruster_layout import Layout, cube
from rvjax.components import user_code
from rvjax.components.actuators.interface import Limits
from rvjax.components.controllers.interface import DiscreteController
from rvjax.components.forms.controller import unlimited
from rvjax.components.guidance import interface as guidance
from rvjax.components.metrics.interface import MetricContext
from rvjax.components.navigation.interface import Known
from rvjax.components.registry import Component
from rvjax.components.user_mistakes import UserMistake
from rvjax.errors import CampaignError
from rvjax.physics.dynamics import Relative, relative
from rvjax.physics.state import Measurement, Motion, Numbers, Plant, Report, State, Step, TargetMotion, Tick
from rvjax.physics.thruster_allocation import Allocation
from rvjax.physics.vectors import Channels, Symmetric, Thrusts, Vector
from rvjax.simulation.effects_sum import effects_sum
from rvjax.simulation.jaxprs import inside

NUMBER = jax.ShapeDtypeStruct((), jnp.float32)
VECTOR = Vector(NUMBER, NUMBER, NUMBER)
CHANNELS = Channels(VECTOR, VECTOR)
SYMMETRIC = Symmetric(*[NUMBER] * 6)


class Arguments(NamedTuple):
    """What the functions of a component get besides its numbers, of a sample at an instant."""

    t: Any
    motion: Motion
    measured: Motion
    target: TargetMotion
    target_alpha: Vector
    plant: Plant
    wrench: Channels
    applied: Channels
    context: MetricContext
    tick: Tick

    @property
    def measurement(self) -> Measurement:
        """Of a controller."""
        plant = self.plant
        return Measurement(self.t, self.measured, self.target, self.target_alpha, plant.port, plant.upper, plant.lower)

    @property
    def known(self) -> Relative:
        """The relative geometry."""
        return relative(self.motion, self.target, self.target_alpha, self.plant.port)


ARGUMENTS = Arguments(
    t=NUMBER,
    motion=Motion(VECTOR, VECTOR, VECTOR, VECTOR),
    measured=Motion(VECTOR, VECTOR, VECTOR, VECTOR),
    target=TargetMotion(VECTOR, VECTOR, VECTOR),
    target_alpha=VECTOR,
    plant=Plant(NUMBER, SYMMETRIC, SYMMETRIC, CHANNELS, CHANNELS, SYMMETRIC, SYMMETRIC, VECTOR, VECTOR),
    wrench=CHANNELS,
    applied=CHANNELS,
    context=MetricContext(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, VECTOR, NUMBER),
    tick=Tick(NUMBER, NUMBER, NUMBER),
)
"""The arguments as shapes."""

Traced = Callable[[Numbers, Arguments], Any]
"""All functions of a component in turn: (its numbers, arguments) → everything that it gives."""


def own_quantities(model: Model) -> dict[str, Quantity]:
    """The quantities that the functions of a component get, by name."""
    quantities = {name.removeprefix("gains."): quantity for name, quantity in model.quantities().items()}
    return {name: quantity for name, quantity in quantities.items() if not name.startswith("schedule.")}


def numbers(quantities: Mapping[str, Quantity], noisy: bool = False) -> Numbers:
    """The shapes of a component's numbers."""
    shapes: Mapping[str, Any] = {"scalar": NUMBER, "vector": VECTOR, "channels": CHANNELS}
    found = {
        name: Thrusts((NUMBER,) * len(quantity.parts)) if quantity.shape == "thrusters" else shapes[quantity.shape]
        for name, quantity in quantities.items()
    }
    return Numbers(found | ({"noise": (NUMBER,) * 4} if noisy else {}))


def unused(file: PythonFile, family: str, member: Component[Any], model: Model, layout: Layout | None) -> list[str]:
    """The names of the numbers that nothing depends on with any choice of the options, of a component in a user's file, which is
    traced. layout: of the thrusters, None without. CampaignError with what is wrong in it."""
    given = numbers(own_quantities(model), member.noisy)
    if family not in _TRACED:
        return []
    function = traced(family, member.build(model), layout)
    kind = jnp.result_type(float)  # in float32 a clock stands still
    exact = jax.tree.map(lambda x: jax.ShapeDtypeStruct(x.shape, kind), (given, ARGUMENTS))
    closed, again = (jax.make_jaxpr(lambda *a: function(*a))(*exact) for _ in range(2))  # JAX keeps a function's trace
    if not _same(closed, again):
        pure = "accepted: functions of their arguments only; no chance, no clock, nothing kept"
        mistake = UserMistake("two traces are different programs", pure)
        raise CampaignError([user_code.finding(mistake, file)])
    dead = _without_effect(closed.jaxpr, given) - (TIMING if family == "faults" else set()) - {"noise"}
    for other in _otherwise(model) if dead else ():
        with suppress(CampaignError):  # of a choice that this campaign does not make
            function, given = traced(family, member.build(other), layout), numbers(own_quantities(other), member.noisy)
            program = jax.make_jaxpr(lambda *a, function=function: function(*a))(given, ARGUMENTS)
            dead &= _without_effect(program.jaxpr, given)
    return sorted(dead)


def _otherwise(model: Model) -> Iterator[Model]:
    """The model with another choice of one of its options, each in turn."""
    for name, info in type(model).model_fields.items():
        option = get_origin(info.annotation) is Literal
        choices = get_args(info.annotation) if option else (False, True) if info.annotation is bool else ()
        yield from (model.model_copy(update={name: choice}) for choice in choices if choice != getattr(model, name))


TIMING = {"onset_s", "duration_s", "period_s", "duty"}
"""Numbers of every fault."""


EXAMPLE = cube(1.0, 2.0)
"""Thrusters for an allocation that is checked by itself."""


def traced(family: str, built: Any, layout: Layout | None = None) -> Traced:
    """The functions of a built component in turn. layout: of the thrusters, None without."""
    return partial(_TRACED[family], built, layout)


def _thrusts(layout: Layout, given: Arguments) -> Thrusts:
    return Thrusts((given.t,) * len(layout.most))


def _controller(built: Any, layout: Layout | None, gains: Numbers, given: Arguments) -> Any:
    del layout
    state = built.start(given.measurement, gains)
    if isinstance(built, DiscreteController):
        return built.update(given.measurement, state, unlimited, gains)
    return built.respond(given.measurement, state, unlimited, gains)


def _fault(built: Any, layout: Layout | None, given_numbers: Numbers, given: Arguments) -> Any:
    u = _thrusts(layout, given) if layout else given.wrench
    memory = built.start(u, given_numbers)
    upper = _thrusts(layout, given) if layout else given.plant.upper
    return built.act(given.t, u, built.keep(given.tick, u, memory, given_numbers), upper, given_numbers)


def _disturbance(built: Any, layout: Layout | None, given_numbers: Numbers, given: Arguments) -> Any:
    del layout
    y = State(given.motion, given.target, ())
    memory = built.keep(given.tick, y, built.start(given_numbers), given_numbers)
    return built.push(given.t, y, given.known, given.plant, memory, given_numbers)


def _navigation(built: Any, layout: Layout | None, given_numbers: Numbers, given: Arguments) -> Any:
    del layout
    truth = Known(given.target, given.target_alpha, given.plant.port)
    informed = built.given(given_numbers, truth)
    memory = built.keep(given.tick, given.motion, built.start(given.motion, informed), informed)
    known = truth if built.knows is None else built.knows(given.t, truth, memory, given_numbers)
    age = () if built.age is None else built.age(given.t, memory)
    return built.see(given.t, given.motion, memory, informed), known, age


def _guidance(built: Any, layout: Layout | None, given_numbers: Numbers, given: Arguments) -> Any:
    del layout
    view = given.measurement
    if built is None:  # direct
        return view.motion
    seen = guidance.Situation(view.t, view.motion, view.target, view.alpha_t, view.port, given.context.axis)
    begun = guidance.started(built, seen, given_numbers)
    memory = guidance.kept(built, given.tick, seen._replace(t=given.tick.t), begun, given_numbers)
    return guidance.followed(view, memory.path.at(given.tick.t + given.tick.h)), memory.kept


def _actuator(built: Any, layout: Layout | None, given_numbers: Numbers, given: Arguments) -> Any:
    u = _thrusts(layout, given) if layout else given.wrench
    most = _thrusts(layout, given) if layout else given.plant.upper
    limits = Limits(most, most)
    memory = built.keep(given.tick, u, built.start(u, given_numbers), limits, given_numbers)
    return built.act(given.tick.t + given.tick.h, u, memory, limits, given_numbers)


def _saturation(built: Any, layout: Layout | None, given_numbers: Numbers, given: Arguments) -> Any:
    del layout, given_numbers
    return built(given.wrench.force.x, given.plant.upper.force.x, given.plant.lower.force.x)


def _allocation(built: Any, layout: Layout | None, given_numbers: Numbers, given: Arguments) -> Any:
    del given_numbers
    allocation: Allocation = built(layout or EXAMPLE)
    return allocation.at(given.wrench)


def _effect(built: Any, layout: Layout | None, given_numbers: Numbers, given: Arguments) -> Any:
    del layout
    state, numbers, effects = built.start(given_numbers), (given_numbers,), (built,)
    total, (slope,), _ = effects_sum(effects, numbers, (state,), given.t, given.known, given.plant, given.wrench)
    moved = jax.tree.map(lambda x, rate: x + 0.1 * rate, state, slope)
    return total, slope, effects_sum(effects, numbers, (moved,), given.t, given.known, given.plant, given.wrench)


def _metric(built: Any, layout: Layout | None, given_numbers: Numbers, given: Arguments) -> Any:
    context = given.context._replace(numbers=given_numbers)
    thrusts = _thrusts(layout, given) if layout else ()
    wrenches = (given.wrench, given.wrench, given.applied, given.wrench)
    report = Report(given.wrench, given.t, {})
    step = Step(given.t, given.motion, given.measured, given.target, given.plant, *wrenches, report, thrusts)
    return built.finish(built.update(built.start(context), step, given.t, context), context)


_TRACED: Mapping[str, Callable[..., Any]] = {
    "controllers": _controller,
    "faults": _fault,
    "disturbances": _disturbance,
    "navigation": _navigation,
    "guidance": _guidance,
    "metrics": _metric,
    "saturations": _saturation,
    "allocations": _allocation,
    "actuators": _actuator,
    "effects": _effect,
}


def _same(first: Any, second: Any) -> bool:
    """Whether two traces are the same program with the same constants."""
    constants = all(np.array_equal(a, b, equal_nan=True) for a, b in zip(first.consts, second.consts, strict=False))
    literals = list(_literals(first.jaxpr)) == list(_literals(second.jaxpr))  # of which the text has only some digits
    return str(first) == str(second) and literals and len(first.consts) == len(second.consts) and constants


def _literals(jaxpr: Any) -> Iterator[bytes]:
    """The numbers that stand in a program, those of the programs in it included."""
    for equation in jaxpr.eqns:
        yield from (np.asarray(atom.val).tobytes() for atom in equation.invars if isinstance(atom, jaxpr_core.Literal))
        for inner in inside(equation):
            yield from _literals(inner)


def _without_effect(jaxpr: Any, given: Numbers) -> set[str]:
    """The names of the numbers that no result depends on."""
    needed = {id(variable) for variable in jaxpr.outvars}
    for equation in reversed(jaxpr.eqns):
        if any(id(variable) in needed for variable in equation.outvars):
            needed |= {id(variable) for variable in equation.invars}
    variables = iter(jaxpr.invars)
    alive = {name: [id(next(variables)) in needed for _ in jax.tree.leaves(given[name])] for name in given}
    return {name for name, uses in alive.items() if not any(uses)}
