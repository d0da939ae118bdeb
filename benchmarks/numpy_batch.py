"""NumPy, batch-vectorised: every equation of a step's jaxpr is one NumPy call on the numbers of all samples."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, Literal

from rvjax.bench.case import Case
from rvjax.flight import Carry

CALLS: Mapping[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "neg": np.negative,
    "abs": np.abs,
    "sign": np.sign,
    "sqrt": np.sqrt,
    "exp": np.exp,
    "tanh": np.tanh,
    "sin": np.sin,
    "cos": np.cos,
    "floor": np.floor,
    "round": np.rint,
    "max": np.maximum,
    "min": np.minimum,
    "ge": np.greater_equal,
    "gt": np.greater,
    "le": np.less_equal,
    "lt": np.less,
    "eq": np.equal,
    "ne": np.not_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    "square": np.square,
    "select_n": lambda which, no, yes: np.where(which, yes, no),
    "clamp": lambda low, x, high: np.minimum(np.maximum(x, low), high),
    "copy": lambda x: x,
    "stop_gradient": lambda x: x,
    "broadcast_in_dim": lambda x, *more: x,
}
NESTED = ("jaxpr", "call_jaxpr")

Numbers = Sequence[Any]
Run = Callable[[Numbers], list[Any]]


def prepare(case: Case) -> Callable[[], Carry]:
    """A function that flies the case."""
    sample = jax.tree.map(lambda x: x[0], (case.drawn, case.carry))
    step = translated(jax.make_jaxpr(case.step)(*sample, 0))
    drawn, structure = jax.tree.leaves(case.drawn), jax.tree.structure(case.carry)

    def fly() -> Carry:
        carry = jax.tree.leaves(case.carry)
        with np.errstate(all="ignore"):
            for k in range(case.steps):
                carry = step([*drawn, *carry, k])
        return jax.tree.unflatten(structure, carry)

    return fly


def translated(closed: ClosedJaxpr) -> Run:
    """The jaxpr as calls on slots of one list, so that a step does nothing but call NumPy."""
    slots: list[Any] = []
    calls: list[tuple[Callable[..., Any], tuple[int, ...], int]] = []

    def new(value: Any = None) -> int:
        slots.append(value)
        return len(slots) - 1

    def walk(jaxpr: Jaxpr, consts: Sequence[Any], arguments: Sequence[int]) -> list[int]:
        place = dict(zip(jaxpr.invars, arguments, strict=True))
        place |= {var: new(value) for var, value in zip(jaxpr.constvars, consts, strict=True)}

        def slot(atom: Any) -> int:
            return new(np.asarray(atom.val)[()]) if isinstance(atom, Literal) else place[atom]

        for equation in jaxpr.eqns:
            operands = [slot(atom) for atom in equation.invars]
            inner = next((equation.params[key] for key in NESTED if key in equation.params), None)
            if inner is not None:
                plain = inner if isinstance(inner, ClosedJaxpr) else ClosedJaxpr(inner, ())
                place.update(zip(equation.outvars, walk(plain.jaxpr, plain.consts, operands), strict=True))
                continue
            (out,) = equation.outvars
            place[out] = new()
            calls.append((_call(equation), tuple(operands), place[out]))
        return [slot(atom) for atom in jaxpr.outvars]

    arguments = [new() for _ in closed.jaxpr.invars]
    results = walk(closed.jaxpr, closed.consts, arguments)

    def run(numbers: Numbers) -> list[Any]:
        slots[: len(arguments)] = numbers
        for function, operands, out in calls:
            slots[out] = function(*[slots[index] for index in operands])
        return [slots[index] for index in results]

    return run


def _call(equation: Any) -> Callable[..., Any]:
    name = equation.primitive.name
    if name == "convert_element_type":
        kind = equation.params["new_dtype"]
        return lambda x: np.asarray(x, dtype=kind)
    if name == "integer_pow":
        power = equation.params["y"]
        return lambda x: x**power
    return CALLS[name]
