"""An interpreter of jaxprs in NumPy: every equation of the jaxpr of a single sample, on arrays with the samples in front.

It imports nothing of rvjax. Arithmetic is NumPy's, which is that of IEEE 754: sums of products are written out, because NumPy
and its libraries may add in another order. Elementary functions are given by the caller as functions of JAX, which are
interpreted too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, reduce
from typing import Any

import jax
import numpy as np
from jax.extend.core import Literal

from tests.oracles.jaxpr_numpy import ARITHMETIC

Array = np.ndarray[Any, Any]
Functions = Mapping[str, Callable[..., Any]]


def interpreted(function: Callable[..., Any], functions: Functions, *trees: Any) -> Any:
    """function(*trees) for every sample, once (`Interpreted`)."""
    return Interpreted(function, functions, *trees)(*trees)


class Interpreted:
    """A function of a single sample, traced once and computed for many.

    functions: primitive → function of JAX that computes it. trees: of arrays (samples, …), or whole numbers, the same for every
    sample.
    """

    def __init__(self, function: Callable[..., Any], functions: Functions, *trees: Any) -> None:
        shapes = jax.tree.map(_shape, trees)
        self._closed, self._results = jax.make_jaxpr(function, return_shape=True)(*shapes)
        self._functions = functions

    def __call__(self, *trees: Any) -> Any:
        leaves = jax.tree.leaves(trees)
        samples = next(len(leaf) for leaf in leaves if np.ndim(leaf))
        rows = [np.full(samples, x, dtype=np.int32) if isinstance(x, int) else np.asarray(x) for x in leaves]
        with np.errstate(all="ignore"):
            values = _Interpreter(self._functions, samples).run(self._closed.jaxpr, self._closed.consts, rows)
        return jax.tree.unflatten(jax.tree.structure(self._results), values)


def _shape(x: Any) -> Any:
    return jax.ShapeDtypeStruct((), np.int32) if isinstance(x, int) else jax.ShapeDtypeStruct(x.shape[1:], x.dtype)


@cache
def _traced(function: Callable[..., Any], *kinds: str) -> Any:
    return jax.make_jaxpr(function)(*[jax.ShapeDtypeStruct((), np.dtype(kind)) for kind in kinds])


class _Interpreter:
    def __init__(self, functions: Functions, samples: int) -> None:
        self.functions, self.samples = functions, samples

    def spread(self, x: Any) -> Array:
        """A constant, for every sample."""
        x = np.asarray(x)
        return np.broadcast_to(x, (self.samples, *x.shape))

    def run(self, jaxpr: Any, constants: Sequence[Any], inputs: Sequence[Array]) -> list[Array]:
        """The results of a jaxpr."""
        held = dict(zip(jaxpr.constvars, map(self.spread, constants), strict=True))
        held.update(zip(jaxpr.invars, inputs, strict=True))

        def read(atom: Any) -> Array:
            return self.spread(np.asarray(atom.val, atom.aval.dtype)) if isinstance(atom, Literal) else held[atom]

        for equation in jaxpr.eqns:
            name, operands = equation.primitive.name, [read(atom) for atom in equation.invars]
            avals = [variable.aval for variable in equation.outvars]
            if name in ("scan", "cond", "while", "split"):
                results = getattr(self, f"_{name}")(equation.params, avals, operands)
            elif (inner := equation.params.get("jaxpr") or equation.params.get("call_jaxpr")) is not None:
                results = self.run(getattr(inner, "jaxpr", inner), getattr(inner, "consts", ()), operands)
            elif name in self.functions:
                closed = _traced(self.functions[name], *(str(x.dtype) for x in operands))
                results = self.run(closed.jaxpr, closed.consts, operands)
            else:
                results = [_SIMPLE[name](equation.params, avals[0], *operands)]
            for variable, value in zip(equation.outvars, results, strict=True):
                held[variable] = np.asarray(value).astype(variable.aval.dtype, copy=False)
        return [read(atom) for atom in jaxpr.outvars]

    def _called(self, closed: Any, operands: Sequence[Array]) -> list[Array]:
        return self.run(closed.jaxpr, closed.consts, operands)

    def _cond(self, params: Mapping[str, Any], avals: Any, operands: list[Array]) -> list[Array]:
        del avals
        which, *given = operands
        results = [self._called(branch, given) for branch in params["branches"]]
        which = np.clip(which.astype(np.int64), 0, len(results) - 1)
        return [np.stack(choices)[which, np.arange(self.samples)] for choices in zip(*results, strict=True)]

    def _scan(self, params: Mapping[str, Any], avals: Any, operands: list[Array]) -> list[Array]:
        first, last = params["num_consts"], params["num_consts"] + params["num_carry"]
        fixed, carry, rows = operands[:first], operands[first:last], operands[last:]
        kept: list[list[Array]] = [[] for _ in avals[params["num_carry"] :]]
        order = range(params["length"])
        for i in reversed(order) if params["reverse"] else order:
            results = self._called(params["jaxpr"], [*fixed, *carry, *(row[:, i] for row in rows)])
            carry = results[: params["num_carry"]]
            for line, value in zip(kept, results[params["num_carry"] :], strict=True):
                line.append(value)
        return [*carry, *(np.stack(line[::-1] if params["reverse"] else line, axis=1) for line in kept)]

    def _while(self, params: Mapping[str, Any], avals: Any, operands: list[Array]) -> list[Array]:
        del avals
        first, last = params["cond_nconsts"], params["cond_nconsts"] + params["body_nconsts"]
        tested, fixed, carry = operands[:first], operands[first:last], operands[last:]
        while True:
            (goes,) = self._called(params["cond_jaxpr"], [*tested, *carry])
            if not goes.any():
                return carry
            new = self._called(params["body_jaxpr"], [*fixed, *carry])
            carry = [np.where(goes.reshape(-1, *[1] * (a.ndim - 1)), a, b) for a, b in zip(new, carry, strict=True)]

    def _split(self, params: Mapping[str, Any], avals: Any, operands: list[Array]) -> list[Array]:
        del avals
        return np.split(operands[0], np.cumsum(params["sizes"])[:-1], axis=params["axis"] + 1)


def _maximum(params: Any, aval: Any, a: Array, b: Array) -> Array:
    """NaN if an operand is NaN; the second of two equal operands."""
    best = np.where(a > b, a, b)
    return np.where(np.isnan(a), a, best) if a.dtype.kind == "f" else best


def _minimum(params: Any, aval: Any, a: Array, b: Array) -> Array:
    best = np.where(a < b, a, b)
    return np.where(np.isnan(a), a, best) if a.dtype.kind == "f" else best


def _power(params: Any, aval: Any, x: Array) -> Array:
    """xⁿ by squares from the lowest bit on."""
    n, result = abs(params["y"]), None
    while n:
        if n & 1:
            result = x if result is None else result * x
        n >>= 1
        x = x * x if n else x
    result = np.ones_like(x) if result is None else result
    return 1 / result if params["y"] < 0 else result


def _converted(params: Any, aval: Any, x: Array) -> Array:
    """Towards zero, at most the largest number of the type; 0 for NaN."""
    kind = np.dtype(aval.dtype)
    if x.dtype.kind == "f" and kind.kind in "iu":
        bounds = np.iinfo(kind)
        wide = np.trunc(np.where(np.isnan(x), 0, x)).astype(np.float64)
        return np.where(wide >= bounds.max, bounds.max, np.where(wide <= bounds.min, bounds.min, wide)).astype(kind)
    return x.astype(kind)


def _rounded(params: Any, aval: Any, x: Array) -> Array:
    if params["rounding_method"] == jax.lax.RoundingMethod.TO_NEAREST_EVEN:
        return np.rint(x)
    whole = np.trunc(x)
    return np.copysign(np.where(np.abs(x - whole) >= 0.5, whole + np.copysign(1.0, x), whole), x)


def _shift(operation: Callable[[Array, Array], Array]) -> Callable[..., Array]:
    def shifted(params: Any, aval: Any, x: Array, by: Array) -> Array:
        width = 8 * x.dtype.itemsize
        inside = (by >= 0) & (by < width)
        return np.where(inside, operation(x, np.where(inside, by, 0)), 0).astype(x.dtype)

    return shifted


def _right(x: Array, by: Array) -> Array:
    unsigned = np.dtype(f"u{x.dtype.itemsize}")
    return (x.view(unsigned) >> by.astype(unsigned)).view(x.dtype)


def _remainder(params: Any, aval: Any, x: Array, y: Array) -> Array:
    if x.dtype.kind == "f":
        return np.fmod(x, y)
    return np.where(y == 0, x, np.fmod(x, np.where(y == 0, 1, y))).astype(x.dtype)


def _divided(params: Any, aval: Any, x: Array, y: Array) -> Array:
    if x.dtype.kind == "f":
        return x / y
    whole = (x - np.fmod(x, np.where(y == 0, 1, y))) // np.where(y == 0, 1, y)
    return np.where(y == 0, -1, whole).astype(x.dtype)


def _axes(axes: Sequence[int]) -> tuple[int, ...]:
    """Axes of a sample, behind that of the samples."""
    return tuple(axis + 1 for axis in axes)


def _reduced(step: Callable[[Array, Array], Array]) -> Callable[..., Array]:
    def row(params: Any, aval: Any, x: Array) -> Array:
        axes = sorted(params["axes"])
        rest = [axis for axis in range(x.ndim - 1) if axis not in axes]
        line = x.transpose([0, *_axes(rest), *_axes(axes)]).reshape(len(x), *aval.shape, -1)
        return reduce(step, [line[..., i] for i in range(line.shape[-1])])

    return row


def _product(params: Any, aval: Any, a: Array, b: Array) -> Array:
    (sum_a, sum_b), (batch_a, batch_b) = params["dimension_numbers"]
    free_a = [axis for axis in range(a.ndim - 1) if axis not in (*sum_a, *batch_a)]
    free_b = [axis for axis in range(b.ndim - 1) if axis not in (*sum_b, *batch_b)]
    n = int(np.prod([a.shape[axis + 1] for axis in sum_a], dtype=int))
    batch = int(np.prod([a.shape[axis + 1] for axis in batch_a], dtype=int))
    left = a.transpose([0, *_axes(batch_a), *_axes(free_a), *_axes(sum_a)]).reshape(len(a), batch, -1, 1, n)
    right = b.transpose([0, *_axes(batch_b), *_axes(free_b), *_axes(sum_b)]).reshape(len(b), batch, 1, -1, n)
    terms = [left[..., i] * right[..., i] for i in range(n)]
    return reduce(np.add, terms).reshape(len(a), *aval.shape)


def _broadcast(params: Any, aval: Any, x: Array, *more: Array) -> Array:
    shape = [1] * len(aval.shape)
    for axis, size in zip(params["broadcast_dimensions"], x.shape[1:], strict=True):
        shape[axis] = size
    return np.broadcast_to(x.reshape(len(x), *shape), (len(x), *aval.shape))


def _sliced(params: Any, aval: Any, x: Array) -> Array:
    strides = params["strides"] or [None] * (x.ndim - 1)
    return x[(slice(None), *map(slice, params["start_indices"], params["limit_indices"], strides))]


def _dynamic(params: Any, aval: Any, x: Array, *starts: Array) -> Array:
    rows: list[Array] = []
    for sample in range(len(x)):
        first = [
            min(max(int(start[sample]), 0), size - part)
            for start, size, part in zip(starts, x.shape[1:], params["slice_sizes"], strict=True)
        ]
        rows.append(x[(sample, *(slice(f, f + part) for f, part in zip(first, params["slice_sizes"], strict=True)))])
    return np.stack(rows)


def _total_order(params: Any, aval: Any, a: Array, b: Array) -> Array:
    if a.dtype.kind != "f":
        return a < b
    bits = [x.view(f"i{x.dtype.itemsize}") for x in (a, b)]
    keys = [np.where(x < 0, x ^ np.iinfo(x.dtype).max, x) for x in bits]
    return keys[0] < keys[1]


def _select(params: Any, aval: Any, which: Array, *cases: Array) -> Array:
    index = np.clip(which.astype(np.int64), 0, len(cases) - 1)
    stacked = np.stack(np.broadcast_arrays(*cases))
    index = np.broadcast_to(index.reshape(index.shape + (1,) * (stacked.ndim - 1 - index.ndim)), stacked.shape[1:])
    return np.take_along_axis(stacked, index[None], axis=0)[0]


def _plain(operation: Callable[..., Array]) -> Callable[..., Array]:
    return lambda params, aval, *operands: operation(*operands)


_SIMPLE: Mapping[str, Callable[..., Array]] = {
    **{name: _plain(operation) for name, operation in ARITHMETIC.items()},
    **{name: _plain(np.copy) for name in ("copy", "copy_p", "stop_gradient")},
    "add_any": _plain(np.add),
    "ceil": _plain(np.ceil),
    "is_finite": _plain(np.isfinite),
    "square": _plain(lambda x: x * x),
    "rsqrt": _plain(lambda x: 1 / np.sqrt(x)),
    "sign": lambda params, aval, x: np.where(x > 0, 1, np.where(x < 0, -1, x)),
    "max": _maximum,
    "min": _minimum,
    "clamp": lambda params, aval, low, x, high: _minimum({}, aval, _maximum({}, aval, x, low), high),
    "integer_pow": _power,
    "convert_element_type": _converted,
    "bitcast_convert_type": lambda params, aval, x: x.view(aval.dtype),
    "round": _rounded,
    "shift_left": _shift(np.left_shift),
    "shift_right_logical": _shift(_right),
    "shift_right_arithmetic": lambda params, aval, x, by: x >> np.clip(by, 0, 8 * x.dtype.itemsize - 1),
    "rem": _remainder,
    "div": _divided,
    "select_n": _select,
    "lt_to": _total_order,
    "reduce_sum": _reduced(np.add),
    "reduce_max": _reduced(lambda a, b: _maximum({}, None, a, b)),
    "reduce_min": _reduced(lambda a, b: _minimum({}, None, a, b)),
    "reduce_and": _reduced(np.bitwise_and),
    "reduce_or": _reduced(np.bitwise_or),
    "dot_general": _product,
    "broadcast_in_dim": _broadcast,
    "reshape": lambda params, aval, x: x.reshape(len(x), *aval.shape),
    "squeeze": lambda params, aval, x: x.reshape(len(x), *aval.shape),
    "expand_dims": lambda params, aval, x: x.reshape(len(x), *aval.shape),
    "transpose": lambda params, aval, x: x.transpose([0, *_axes(params["permutation"])]),
    "slice": _sliced,
    "dynamic_slice": _dynamic,
    "concatenate": lambda params, aval, *x: np.concatenate(x, axis=params["dimension"] + 1),
}  # fmt: skip
"""Primitive → operation on arrays with the samples in front."""
