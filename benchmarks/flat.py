"""A jaxpr as one list of calls: what lies in nested jaxprs (`jit`, …) stands in the list where it is called.

An elementary function of `rvjax.physics.elementary` is a call by its name: a yardstick takes that of its library.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, JaxprEqn, Literal

NESTED = ("jaxpr", "call_jaxpr")
LIBRARY = ("cos", "exp", "log", "sin", "tanh")
"""Elementary functions that every yardstick has in a library."""


class Constant(NamedTuple):
    """A number that is known when the code is written."""

    value: np.generic


Operand = int | Constant
"""Where a number is: its slot, or the number itself."""


class Call(NamedTuple):
    """name: of the primitive or of the elementary function."""

    name: str
    equation: JaxprEqn
    operands: list[Operand]


class Flat(NamedTuple):
    """inputs: numbers that are given, in the slots from 0 on. The result of call i has the slot inputs + i. results: what is
    given back."""

    inputs: int
    calls: list[Call]
    results: list[Operand]


def flat(closed: ClosedJaxpr) -> Flat:
    """The calls of a jaxpr in which every equation that is no nested jaxpr has one result."""
    inputs = len(closed.jaxpr.invars)
    calls: list[Call] = []

    def walk(jaxpr: Jaxpr, consts: Sequence[Any], arguments: Sequence[Operand]) -> list[Operand]:
        place: dict[Any, Operand] = dict(zip(jaxpr.invars, arguments, strict=True))
        place |= {var: _constant(value) for var, value in zip(jaxpr.constvars, consts, strict=True)}

        def find(atom: Any) -> Operand:
            return _constant(atom.val) if isinstance(atom, Literal) else place[atom]

        for equation in jaxpr.eqns:
            operands = [find(atom) for atom in equation.invars]
            inner = next((equation.params[key] for key in NESTED if key in equation.params), None)
            name = _name(equation)
            if inner is None or name in LIBRARY:
                (out,) = equation.outvars
                place[out] = inputs + len(calls)
                calls.append(Call(name, equation, operands))
            else:
                plain = inner if isinstance(inner, ClosedJaxpr) else ClosedJaxpr(inner, ())
                place.update(zip(equation.outvars, walk(plain.jaxpr, plain.consts, operands), strict=True))
        return [find(atom) for atom in jaxpr.outvars]

    results = walk(closed.jaxpr, closed.consts, range(inputs))
    return Flat(inputs, calls, results)


def _name(equation: JaxprEqn) -> str:
    """The name of a primitive, or of a function that brings its derivative along."""
    name = equation.primitive.name
    return equation.params["call_jaxpr"].jaxpr.debug_info.func_name if name == "custom_jvp_call" else name


def _constant(value: Any) -> Constant:
    return Constant(np.asarray(value)[()])
