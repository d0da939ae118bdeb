"""A jaxpr as one list of calls: what lies in nested jaxprs (`jit`, …) stands in the list where it is called."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, JaxprEqn, Literal

NESTED = ("jaxpr", "call_jaxpr")


class Constant(NamedTuple):
    """A number that is known when the code is written."""

    value: np.generic


Operand = int | Constant
"""Where a number is: its slot, or the number itself."""


class Flat(NamedTuple):
    """inputs: numbers that are given, in the slots from 0 on. calls: equation and operands; the result of call i has the slot
    inputs + i. results: what is given back."""

    inputs: int
    calls: list[tuple[JaxprEqn, list[Operand]]]
    results: list[Operand]


def flat(closed: ClosedJaxpr) -> Flat:
    """The calls of a jaxpr in which every equation that is no nested jaxpr has one result."""
    inputs = len(closed.jaxpr.invars)
    calls: list[tuple[JaxprEqn, list[Operand]]] = []

    def walk(jaxpr: Jaxpr, consts: Sequence[Any], arguments: Sequence[Operand]) -> list[Operand]:
        place: dict[Any, Operand] = dict(zip(jaxpr.invars, arguments, strict=True))
        place |= {var: _constant(value) for var, value in zip(jaxpr.constvars, consts, strict=True)}

        def find(atom: Any) -> Operand:
            return _constant(atom.val) if isinstance(atom, Literal) else place[atom]

        for equation in jaxpr.eqns:
            operands = [find(atom) for atom in equation.invars]
            inner = next((equation.params[key] for key in NESTED if key in equation.params), None)
            if inner is None:
                (out,) = equation.outvars
                place[out] = inputs + len(calls)
                calls.append((equation, operands))
            else:
                plain = inner if isinstance(inner, ClosedJaxpr) else ClosedJaxpr(inner, ())
                place.update(zip(equation.outvars, walk(plain.jaxpr, plain.consts, operands), strict=True))
        return [find(atom) for atom in jaxpr.outvars]

    results = walk(closed.jaxpr, closed.consts, range(inputs))
    return Flat(inputs, calls, results)


def _constant(value: Any) -> Constant:
    return Constant(np.asarray(value)[()])
