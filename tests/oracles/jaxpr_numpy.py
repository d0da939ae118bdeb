"""Evaluates a jaxpr with NumPy: one IEEE 754 operation of the processor per equation, nothing contracted, rewritten or flushed.

Only the primitives that elementary functions may use are known; another one is an error.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import jax
import numpy as np

ARITHMETIC: dict[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "sqrt": np.sqrt,
    "neg": np.negative,
    "abs": np.abs,
    "min": np.minimum,
    "max": np.maximum,
    "floor": np.floor,
    "lt": np.less,
    "le": np.less_equal,
    "gt": np.greater,
    "ge": np.greater_equal,
    "eq": np.equal,
    "ne": np.not_equal,
    "and": np.bitwise_and,
    "or": np.bitwise_or,
    "xor": np.bitwise_xor,
    "not": np.bitwise_not,
    "shift_left": np.left_shift,
    "shift_right_arithmetic": np.right_shift,
    "select_n": lambda chosen, no, yes: np.where(chosen, yes, no),
}
FREE = ("bitcast_convert_type", "broadcast_in_dim", "convert_element_type", "squeeze")
"""Primitives that compute nothing: another view, another shape, the type of a constant."""

INNER = {"jit": "jaxpr", "pjit": "jaxpr", "custom_jvp_call": "call_jaxpr"}
"""Primitives that hold a jaxpr, and under which name."""


def evaluate(function: Callable[..., Any], *arguments: Any) -> Any:
    """function(*arguments) in NumPy; arguments: NumPy arrays of one shape."""
    closed = jax.make_jaxpr(function)(*arguments)
    with np.errstate(all="ignore"):
        (result,) = _run(closed, arguments, Counter())
    return result


def operations(function: Callable[..., Any], *arguments: Any) -> Counter[str]:
    """How often each primitive that computes stands in the jaxpr."""
    count: Counter[str] = Counter()
    with np.errstate(all="ignore"):
        _run(jax.make_jaxpr(function)(*arguments), arguments, count)
    return Counter({name: times for name, times in count.items() if name not in FREE})


def _run(closed: Any, arguments: Sequence[Any], count: Counter[str]) -> list[Any]:
    known: dict[Any, Any] = dict(zip(closed.jaxpr.constvars, closed.consts, strict=True))
    known |= dict(zip(closed.jaxpr.invars, arguments, strict=True))

    def value(atom: Any) -> Any:
        return np.asarray(atom.val if hasattr(atom, "val") else known[atom])

    for equation in closed.jaxpr.eqns:
        values = [value(atom) for atom in equation.invars]
        name = equation.primitive.name
        if name in INNER:
            results = _run(equation.params[INNER[name]], values, count)
        else:
            count[name] += 1
            results = [_apply(name, values, equation.params)]
        for variable, result in zip(equation.outvars, results, strict=True):
            assert result.dtype == variable.aval.dtype, (name, result.dtype, variable.aval)
            known[variable] = result
    return [value(atom) for atom in closed.jaxpr.outvars]


def _apply(name: str, values: list[Any], params: dict[str, Any]) -> Any:
    if name == "round":
        assert params["rounding_method"] == jax.lax.RoundingMethod.TO_NEAREST_EVEN
        return np.rint(values[0])
    if name == "bitcast_convert_type":
        return values[0].view(params["new_dtype"])
    if name == "convert_element_type":
        return values[0].astype(params["new_dtype"])
    if name == "broadcast_in_dim":
        assert values[0].shape in ((), params["shape"])
        return np.broadcast_to(values[0], params["shape"])
    if name == "squeeze":
        return np.squeeze(values[0], params["dimensions"])
    return np.asarray(ARITHMETIC[name](*values))
