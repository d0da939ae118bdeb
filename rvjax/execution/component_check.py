"""The check of a component by itself: it is traced, then computed at many states.

    traced    kinds, shapes and types of what comes back; declared signals and no others; a pure function; every number is used
    computed  finite at STATES drawn states; which numbers change no result there
    cost      operations of an evaluation, in multiples of those of the controller pd-plus

The states are those of a rendezvous: positions, speeds, rates and limits within SIZES. An allocation has 24 thrusters here
(`user_checks.EXAMPLE`), any other component has the six channels.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from pydantic import ValidationError

from rvjax.campaign import Model, Quantity
from rvjax.campaign.python_files import PythonFile, read_file
from rvjax.components import user_code
from rvjax.components.manual_examples import mappings
from rvjax.components.registry import ANY, Component, component, family_built, family_of
from rvjax.components.user_mistakes import UserMistake
from rvjax.errors import CampaignError, Finding
from rvjax.physics.state import Numbers
from rvjax.simulation import jax_config, user_checks

STATES = 64
SEED = 20181
STEP = 0.1
"""Relative change of a number whose effect on the results is looked at."""

SIZES = {
    "t": 300.0,
    "rho": 20.0,
    "nu": 0.5,
    "sigma": 0.4,
    "omega": 0.05,
    "r": 4.0e6,
    "v": 4.0e3,
    "w": 0.01,
    "upper": 4.0,
    "lower": 3.0,
}
"""Half widths of the states: lengths in m, speeds in m/s, rates in rad/s, limits in N and N·m."""

POSITIVE = (
    "upper",
    "lower",
    "mass",
    "inertia",
    "thrust",
    "t",
    "window_start_s",
    "duration_s",
    "step_s",
    "tube_m",
    "tube_mrp",
    "h",
    "k",
)


@dataclass(frozen=True)
class Checked:
    """A component that passed. family, parameters: names of its numbers; signals: of its signals or columns; operations: of an
    evaluation; cost: in multiples of pd-plus. idle: numbers whose change by STEP changes no result at the drawn states."""

    name: str
    family: str
    parameters: tuple[str, ...]
    signals: tuple[str, ...]
    operations: int
    cost: float
    idle: tuple[str, ...] = ()


def check_file(file: str | Path, parameters: Mapping[str, Any] | None = None) -> tuple[Checked, ...]:
    """Checks every component of a file, or `FILE:NAME` only. parameters: as a campaign says them, of a single component.

    Errors: CampaignError as of `check`, also where the file has no component.
    """
    jax_config.configure()
    found = read_file(file)
    module = user_code.module_of(found)
    held = {name: family for name, value in vars(module).items() if (family := family_of(value)) and not name.startswith("_")}
    names = [found.member] if found.member else [name for name, family in held.items() if family != ANY or name == "COMPONENT"]
    if not names or names[0] not in held:
        accepted = (
            f"accepted: {', '.join(held)}" if held else "accepted: a component, such as `rvjax init --controller FILE` writes"
        )
        raise CampaignError([Finding(f"{found.path(found.file)}:1", "", _absent(module, found.member), accepted)])
    files = {name: PythonFile(f"{found.file}:{name}", found.file, name, found.folder, found.sources) for name in names}
    return tuple(_check_object(files[name], held[name], parameters) for name in names)


def _check_object(file: PythonFile, family: str, parameters: Mapping[str, Any] | None) -> Checked:
    """Checks an object of a file. family: what the object says."""
    member = component(family, file)
    if family == ANY:
        family = family_built(member.build(_model(member.parameters, parameters)))
        if family == ANY:
            mistake = UserMistake(f"{file.member} does not say its family", "accepted: a form, such as Saturation(limited)")
            raise CampaignError([user_code.finding(mistake, file)])
    return check(file, family, member, parameters)


def check(file: PythonFile | str, family: str, member: Component[Any], parameters: Mapping[str, Any] | None = None) -> Checked:
    """Checks a component. parameters: as a campaign says them; without them an example of its model.

    Errors: CampaignError with the line of the user's code and what is wrong.
    """
    model = _model(member.parameters, parameters)
    if isinstance(file, PythonFile) and (dead := user_checks.unused(file, family, member, model, None)):
        accepted = "accepted: a parameter that something depends on"
        raise CampaignError([Finding(_declared(file, name), "", f"{file.file} does not use {name}", accepted) for name in dead])
    built = member.build(model)
    function = user_checks.traced(family, built)
    compute = jax.jit(jax.vmap(function, in_axes=(None, 0)))
    quantities = user_checks.own_quantities(model)
    given = _numbers(quantities, member.noisy)
    states = _states()
    results = compute(given, states)
    _check_finite(file, results)
    idle = _idle(lambda numbers: compute(numbers, states), quantities, given, results)
    signals = getattr(built, "signals", None) or getattr(built, "columns", None) or {}
    operations = _operations(function, given)
    baseline = component("controllers", "pd-plus")
    plain = baseline.parameters()
    basis = _operations(
        user_checks.traced("controllers", baseline.build(plain)), _numbers(user_checks.own_quantities(plain), False)
    )
    names = tuple(member.parameters.keys() if family == "allocations" else quantities)
    return Checked(str(file), family, names, tuple(signals), operations, operations / basis, idle)


def _absent(module: ModuleType, name: str) -> str:
    """Why there is nothing to check. name: of the object that was asked for, "" for any."""
    if not name:
        return "there is no component in the file"
    if name not in vars(module):
        return f"there is no {name}"
    return f"{name} is a {type(vars(module)[name]).__name__}, not a component"


def _declared(file: PythonFile, name: str) -> str:
    """`file:line` where a parameter is declared, else the beginning of the file."""
    for source, data in file.sources.items():
        for node in ast.walk(ast.parse(data)):
            if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.target.id == name:
                return f"{file.path(source)}:{node.lineno}"
    return f"{file.path(file.file)}:1"


def _model(form: type[Model], parameters: Mapping[str, Any] | None) -> Model:
    if parameters is not None:
        return form.model_validate(dict(parameters))
    try:
        return form.model_validate({})
    except ValidationError:
        return form.model_validate(next(mappings(form)))


def _numbers(quantities: Mapping[str, Quantity], noisy: bool) -> Numbers:
    """The medians of the numbers."""
    shapes = user_checks.numbers(quantities, noisy)
    values: dict[str, Any] = {}
    for name, shape in shapes.items():
        leaves, structure = jax.tree.flatten(shape)
        medians = quantities[name].medians if name in quantities else (1.0, 2.0, 3.0, 4.0)
        filled = [float(medians[i % len(medians)]) for i in range(len(leaves))]
        values[name] = jax.tree.unflatten(structure, [jnp.asarray(x) for x in filled])
    return Numbers(values)


def _states() -> Any:
    """STATES drawn arguments of a component: positions, rates and bodies as in a rendezvous."""
    chance = np.random.default_rng(SEED)

    def draw(path: Any, shape: Any) -> Any:
        del shape
        names = [str(getattr(step, "name", "")) for step in path]
        size = next((SIZES[name] for name in reversed(names) if name in SIZES), 1.0)
        numbers = chance.uniform(-size, size, STATES)
        if any(name in POSITIVE for name in names):
            numbers = np.abs(numbers) + 0.1 * size
        return jnp.asarray(numbers)

    return jax.tree_util.tree_map_with_path(draw, user_checks.ARGUMENTS)


def _check_finite(file: PythonFile | str, results: Any) -> None:
    for path, leaf in jax.tree_util.tree_flatten_with_path(results)[0]:
        values = np.asarray(leaf, dtype=np.float64).reshape(STATES, -1)
        wrong = ~np.all(np.isfinite(values), axis=1)
        if wrong.any():
            name = jax.tree_util.keystr(path, simple=True, separator=".").strip("012345.") or "its result"
            words = f"{name} is not finite at {int(wrong.sum())} of {STATES} states"
            raise CampaignError([_finding(file, words, "accepted: finite numbers at every state")])


def _idle(compute: Any, quantities: Mapping[str, Quantity], given: Numbers, results: Any) -> tuple[str, ...]:
    """The numbers whose change changes no result. compute: the results for other numbers."""
    before, idle = jax.tree.leaves(results), list[str]()
    for name in quantities.keys() - user_checks.TIMING:
        moved = Numbers({**given, name: jax.tree.map(lambda x: x * (1.0 + STEP) + STEP * (x == 0.0), given[name])})
        after = jax.tree.leaves(compute(moved))
        if all(np.array_equal(a, b, equal_nan=True) for a, b in zip(before, after, strict=True)):
            idle.append(name)
    return tuple(sorted(idle))


def _operations(function: Any, given: Numbers) -> int:
    """Numbers that an evaluation computes, on the way to its results."""
    closed = jax.make_jaxpr(lambda numbers, states: function(numbers, states))(given, user_checks.ARGUMENTS)
    return _count(closed.jaxpr)


def _count(jaxpr: Any) -> int:
    total = 0
    for equation in jaxpr.eqns:
        inner = [
            getattr(value, "jaxpr", value)
            for value in equation.params.values()
            if hasattr(value, "eqns") or hasattr(value, "jaxpr")
        ]
        if inner:
            total += sum(_count(part) for part in inner)
        elif equation.primitive.name not in _MOVES:
            total += sum(int(np.prod(variable.aval.shape)) for variable in equation.outvars)
    return total


_MOVES = {"broadcast_in_dim", "concatenate", "reshape", "slice", "squeeze", "transpose", "convert_element_type", "copy"}
"""Primitives that compute nothing."""


def _finding(file: PythonFile | str, found: str, accepted: str) -> Any:
    if isinstance(file, PythonFile):
        return user_code.finding(UserMistake(found, accepted), file)
    return Finding(str(file), "", found, accepted)
