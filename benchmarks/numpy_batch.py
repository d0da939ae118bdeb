"""NumPy, batch-vectorised: every equation of a step's jaxpr is one NumPy call on the numbers of all samples."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import numpy as np
from jax.extend.core import ClosedJaxpr

from benchmarks.flat import Call, Constant, Operand, flat
from rvjax.execution.bench.workload import Case
from rvjax.simulation.flight import Carry

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
    "log": np.log,
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
    whole = flat(closed)
    slots: list[Any] = [None] * (whole.inputs + len(whole.calls))

    def slot(operand: Operand) -> int:
        if not isinstance(operand, Constant):
            return operand
        slots.append(operand.value)
        return len(slots) - 1

    calls = [
        (_call(call), [slot(operand) for operand in call.operands], whole.inputs + number)
        for number, call in enumerate(whole.calls)
    ]
    results = [slot(one) for one in whole.results]

    def run(numbers: Numbers) -> list[Any]:
        slots[: whole.inputs] = numbers
        for function, operands, out in calls:
            slots[out] = function(*[slots[index] for index in operands])
        return [slots[index] for index in results]

    return run


def _call(call: Call) -> Callable[..., Any]:
    if call.name == "convert_element_type":
        kind = call.equation.params["new_dtype"]
        return lambda x: np.asarray(x, dtype=kind)
    if call.name == "integer_pow":
        power = call.equation.params["y"]
        return lambda x: x**power
    return CALLS[call.name]
