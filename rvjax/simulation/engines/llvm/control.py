"""Primitives of JAX with a jaxpr inside: functions, choices and loops.

A choice that is the same in all lanes is a branch; else both sides are computed and selected. A loop of fixed length is
unrolled if it is short. In other loops every lane goes on as long as its condition holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rvjax.simulation.engines.llvm.arrays import Row, Values, lookup
from rvjax.simulation.engines.llvm.elementwise import apply
from rvjax.simulation.engines.llvm.program import BOOL, INT32, Builder, Region, UnsupportedError, Value
from rvjax.simulation.jaxprs import inside

UNROLLED = 4000
"""Most equations of a loop that is unrolled."""


def _called(to: Builder, closed: Any, operands: Sequence[Values]) -> list[Values]:
    """The results of a closed jaxpr."""
    from rvjax.simulation.engines.llvm.from_jaxpr import constants_of, evaluated

    return evaluated(to, getattr(closed, "jaxpr", closed), constants_of(to, closed), operands)


def function(key: str) -> Row:
    """A call of a jaxpr that is a parameter."""
    return lambda to, params, avals, operands: _called(to, params[key], operands)


def equations(jaxpr: Any) -> int:
    """The equations of a jaxpr, those inside of others included."""
    return len(jaxpr.eqns) + sum(equations(part) for equation in jaxpr.eqns for part in inside(equation))


def _flat(arrays: Sequence[Values]) -> list[Value]:
    return [int(value) for array in arrays for value in array.flat]


def _shaped(values: Sequence[Value], avals: Sequence[Any]) -> list[Values]:
    """Values as arrays of these shapes."""
    line, result, first = np.array(values, dtype=np.int64), list[Values](), 0
    for aval in avals:
        count = int(np.prod(aval.shape, dtype=np.int64))
        result.append(line[first : first + count].reshape(aval.shape))
        first += count
    return result


def _choice(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    which, *given = operands
    return _chosen(to, int(which), list(params["branches"]), avals, given)


def _chosen(to: Builder, which: Value, branches: list[Any], avals: Sequence[Any], given: list[Values]) -> Sequence[Values]:
    """The results of the branch with a number; a number outside is moved to the nearest."""
    if len(branches) == 1:
        return _called(to, branches[0], given)
    if (known := to.number(which)) is not None:
        return _called(to, branches[min(max(int(known), 0), len(branches) - 1)], given)
    first = apply(to, "le", BOOL, which, to.constant(0, to.type(which)))
    following = apply(to, "sub", to.type(which), which, to.constant(1, to.type(which)))
    sides = [lambda: _called(to, branches[0], given), lambda: _chosen(to, following, branches[1:], avals, given)]
    kinds = [np.dtype(aval.dtype) for aval in avals for _ in range(int(np.prod(aval.shape, dtype=np.int64)))]
    if not to.program.uniform[first]:
        yes, no = (_flat(side()) for side in sides)
        return _shaped([to.emit("select", kind, first, a, b) for kind, a, b in zip(kinds, yes, no, strict=True)], avals)
    regions: list[Region] = []
    for side in sides:
        with to.region() as close:
            regions.append(close((), _flat(side())))
    same = [all(to.program.uniform[value] for value in pair) for pair in zip(regions[0].results, regions[1].results, strict=True)]
    return _shaped(to.structured("branch", kinds, same, (first,), regions), avals)


def _scan(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    constants, carries, length, closed = params["num_consts"], params["num_carry"], params["length"], params["jaxpr"]
    fixed, carry, rows = operands[:constants], operands[constants : constants + carries], operands[constants + carries :]
    given = len(avals) > carries
    if length * equations(closed.jaxpr) > UNROLLED and not given and length > 1:
        return _loop(to, closed, length, fixed, carry, rows, avals, params["reverse"])
    if length * equations(closed.jaxpr) > 16 * UNROLLED:
        raise UnsupportedError("with a result of each of its many iterations")
    kept: list[list[Values]] = [[] for _ in avals[carries:]]
    for i in reversed(range(length)) if params["reverse"] else range(length):
        results = _called(to, closed, [*fixed, *carry, *(row[i] for row in rows)])
        carry = results[:carries]
        for line, value in zip(kept, results[carries:], strict=True):
            line.append(value)
    ends = [np.stack(line[::-1] if params["reverse"] else line) if line else np.zeros(aval.shape, dtype=np.int64)
            for line, aval in zip(kept, avals[carries:], strict=True)]  # fmt: skip
    return [*carry, *ends]


def _loop(
    to: Builder,
    closed: Any,
    length: int,
    fixed: list[Values],
    carry: list[Values],
    rows: list[Values],
    avals: Sequence[Any],
    reverse: bool,
) -> Sequence[Values]:
    """A loop of fixed length."""
    first = _flat(carry)
    kinds = [to.type(value) for value in first]
    same = [to.program.uniform[value] for value in first]
    while True:
        with to.region() as close:
            index = to.new(INT32, True)
            arguments = [to.new(kind, uniform) for kind, uniform in zip(kinds, same, strict=True)]
            at = apply(to, "sub", INT32, to.constant(length - 1, INT32), index) if reverse else index
            now = [_row(to, at, row) for row in rows]
            results = _flat(_called(to, closed, [*fixed, *_shaped(arguments, avals), *now]))
            region = close((index, *arguments), results)
        still = [a and to.program.uniform[b] for a, b in zip(same, results, strict=True)]
        if still == same:
            return _shaped(to.structured("loop", kinds, same, first, (region,), length), avals)
        same = still


def _row(to: Builder, index: Value, rows: Values) -> Values:
    """The row of an array at an index."""
    result = np.empty(rows.shape[1:], dtype=np.int64)
    for place in np.ndindex(result.shape):
        result[place] = lookup(to, (index,), (len(rows),), rows[(slice(None), *place)])
    return result


def _while(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    before, inside = params["cond_nconsts"], params["body_nconsts"]
    tested, fixed, carry = operands[:before], operands[before : before + inside], operands[before + inside :]
    first = _flat(carry)
    kinds = [to.type(value) for value in first]
    same = [to.program.uniform[value] for value in first]
    while True:
        with to.region() as close:
            arguments = [to.new(kind, uniform) for kind, uniform in zip(kinds, same, strict=True)]
            (goes,) = _flat(_called(to, params["cond_jaxpr"], [*tested, *_shaped(arguments, avals)]))
            results = _flat(_called(to, params["body_jaxpr"], [*fixed, *_shaped(arguments, avals)]))
            if not to.program.uniform[goes]:
                rows = zip(kinds, results, arguments, strict=True)
                results = [to.emit("select", kind, goes, new, old) for kind, new, old in rows]
            region = close(arguments, (goes, *results))
        still = [a and to.program.uniform[b] for a, b in zip(same, results, strict=True)]
        if still == same:
            return _shaped(to.structured("while", kinds, same, first, (region,)), avals)
        same = still


ROWS: Mapping[str, Row] = {
    "jit": function("jaxpr"),
    "pjit": function("jaxpr"),
    "call": function("call_jaxpr"),
    "closed_call": function("call_jaxpr"),
    "custom_jvp_call": function("call_jaxpr"),
    "custom_vjp_call": function("call_jaxpr"),
    "remat2": function("jaxpr"),
    "remat_opt": function("jaxpr"),
    "cond": _choice,
    "scan": _scan,
    "while": _while,
}
"""Primitive → what it does."""
