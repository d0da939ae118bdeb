"""A jaxpr as a scalar program: arrays become arrays of values, so what moves numbers costs nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import jax
import numpy as np
from jax.extend.core import Literal

from rvjax.simulation.engines.llvm import arrays, control, elementwise
from rvjax.simulation.engines.llvm.arrays import Values
from rvjax.simulation.engines.llvm.program import INT32, Builder, Program, UnsupportedError, Value


def scalarised(function: Callable[..., Any], *examples: Any, step: bool = True) -> tuple[Program, Any]:
    """(the program of a function of a single sample, its results as shapes). examples: trees of shapes. step: the last argument
    is the number of the step, the same in every lane. Inputs and results: the numbers of all leaves, in their order.

    Errors: UnsupportedError, which names the primitive.
    """
    closed, results = jax.make_jaxpr(function, return_shape=True)(*examples)
    return of_jaxpr(closed, step), results


def of_jaxpr(closed: Any, step: bool = True) -> Program:
    """The program of a jaxpr."""
    to = Builder()
    inputs = [
        _input(to, variable.aval, step and place == len(closed.jaxpr.invars) - 1)
        for place, variable in enumerate(closed.jaxpr.invars)
    ]
    results = evaluated(to, closed.jaxpr, constants_of(to, closed), inputs)
    flat = [int(value) for array in inputs for value in array.flat]
    return to.finished(flat, [int(value) for array in results for value in array.flat])


def _input(to: Builder, aval: Any, uniform: bool) -> Values:
    count = int(np.prod(aval.shape, dtype=np.int64))
    kind = INT32 if uniform else np.dtype(aval.dtype)
    return np.array([to.new(kind, uniform) for _ in range(count)], dtype=np.int64).reshape(aval.shape)


def _constant(to: Builder, number: Any) -> Values:
    array = np.asarray(number)
    return np.array([to.constant(entry, array.dtype) for entry in array.flat], dtype=np.int64).reshape(array.shape)


def constants_of(to: Builder, closed: Any) -> list[Values]:
    """The constants of a jaxpr; `call_jaxpr` of some primitives has none."""
    return [_constant(to, const) for const in getattr(closed, "consts", ())]


def inlined(to: Builder, closed: Any, operands: Sequence[Value]) -> list[Value]:
    """The results of a jaxpr of numbers, from values."""
    given = [np.asarray(operand, dtype=np.int64) for operand in operands]
    results = evaluated(to, closed.jaxpr, constants_of(to, closed), given)
    return [int(result) for result in results]


def evaluated(to: Builder, jaxpr: Any, constants: Sequence[Values], inputs: Sequence[Values]) -> list[Values]:
    """The results of a jaxpr, from the values of its inputs."""
    held: dict[Any, Values] = dict(zip(jaxpr.constvars, constants, strict=True))
    held.update(zip(jaxpr.invars, inputs, strict=True))

    def read(atom: Any) -> Values:
        if isinstance(atom, Literal):
            return _constant(to, np.asarray(atom.val, dtype=getattr(atom.aval, "dtype", None)))
        return held[atom]

    for equation in jaxpr.eqns:
        results = _equation(to, equation, [read(atom) for atom in equation.invars])
        held.update(zip(equation.outvars, results, strict=True))
    return [read(atom) for atom in jaxpr.outvars]


def _equation(to: Builder, equation: Any, operands: list[Values]) -> Sequence[Values]:
    """The results of an equation."""
    name = equation.primitive.name
    try:
        if (row := elementwise.ROWS.get(name)) is not None:
            return (_each(to, row, equation, operands),)
        if (row := arrays.ROWS.get(name) or control.ROWS.get(name)) is not None:
            avals = [variable.aval for variable in equation.outvars]
            results = row(to, equation.params, avals, operands)
            if [result.shape for result in results] != [aval.shape for aval in avals]:
                raise AssertionError(f"`{name}`: {[result.shape for result in results]} for {avals}")
            return results
    except UnsupportedError as error:
        raise UnsupportedError(str(error) if str(error).startswith("`") else f"`{name}` {error}") from None
    raise UnsupportedError(f"`{name}`")


def _each(to: Builder, row: elementwise.Row, equation: Any, operands: list[Values]) -> Values:
    """A row of the table for every number of the arrays."""
    aval = equation.outvars[0].aval
    kind = np.dtype(aval.dtype)
    if aval.shape == ():
        return np.asarray(row(to, equation.params, kind, tuple(map(int, operands))), dtype=np.int64)
    columns = [np.broadcast_to(operand, aval.shape).ravel().tolist() for operand in operands]
    results = [row(to, equation.params, kind, numbers) for numbers in zip(*columns, strict=True)]
    return np.array(results, dtype=np.int64).reshape(aval.shape)
