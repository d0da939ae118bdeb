"""Primitives of JAX that move the numbers of arrays, and sums and products of them.

Moving costs nothing: an array is an array of values. Sums and products take their terms in the order of the indices, the first
index the slowest. A number that is looked up by an index of every lane is a `lookup` in a list of values.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
from jax.lax import GatherScatterMode
from numpy.typing import NDArray

from rvjax.simulation.engines.llvm.elementwise import apply
from rvjax.simulation.engines.llvm.program import BOOL, INT32, Builder, Type, UnsupportedError, Value

Values = NDArray[np.int64]
"""The values of an array, in its shape."""

Row = Callable[[Builder, Mapping[str, Any], Sequence[Any], list[Values]], Sequence[Values]]
"""(builder, parameters of the primitive, types of the results, operands) → results."""


def moved(move: Callable[[Mapping[str, Any], Any, Values], Values]) -> Row:
    """A row that puts the values of an array in other places."""
    return lambda to, params, avals, operands: (move(params, avals[0], operands[0]),)


def _broadcast(params: Mapping[str, Any], aval: Any, x: Values) -> Values:
    shape = [1] * len(aval.shape)
    for axis, size in zip(params["broadcast_dimensions"], x.shape, strict=True):
        shape[axis] = size
    return np.broadcast_to(x.reshape(shape), aval.shape)


def _sliced(params: Mapping[str, Any], aval: Any, x: Values) -> Values:
    del aval
    steps = params["strides"] or (1,) * x.ndim
    return x[tuple(slice(*ends) for ends in zip(params["start_indices"], params["limit_indices"], steps, strict=True))]


def _concatenated(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    del to, avals
    return (np.concatenate(operands, axis=params["dimension"]),)


def _padded(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    del to
    x, filling = operands
    result = np.full(avals[0].shape, int(filling), dtype=np.int64)
    for index in np.ndindex(x.shape):
        place = tuple(low + i * (inner + 1) for i, (low, _, inner) in zip(index, params["padding_config"], strict=True))
        if all(0 <= p < size for p, size in zip(place, result.shape, strict=True)):
            result[place] = x[index]
    return (result,)


def _counted(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    """0, 1, 2, … along an axis."""
    del operands
    shape, axis, kind = avals[0].shape, params["dimension"], np.dtype(avals[0].dtype)
    line = np.array([to.constant(i, kind) for i in range(shape[axis])], dtype=np.int64)
    return (np.broadcast_to(line.reshape([-1 if i == axis else 1 for i in range(len(shape))]), shape),)


def _split(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    del to, avals
    return np.split(operands[0], np.cumsum(params["sizes"])[:-1], axis=params["axis"])


def _stacked(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    del to, avals
    return (np.stack(operands, axis=params["axis"]),)


def _unstacked(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    del to, avals
    return list(np.moveaxis(operands[0], params["axis"], 0))


def _products(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    """Σ aᵢ bᵢ over the contracted axes."""
    a, b = operands
    (contracted_a, contracted_b), (batch_a, batch_b) = params["dimension_numbers"]
    kind = np.dtype(avals[0].dtype)
    free_a = [axis for axis in range(a.ndim) if axis not in (*contracted_a, *batch_a)]
    free_b = [axis for axis in range(b.ndim) if axis not in (*contracted_b, *batch_b)]
    count = int(np.prod([a.shape[axis] for axis in contracted_a], dtype=np.int64))
    batch = int(np.prod([a.shape[axis] for axis in batch_a], dtype=np.int64))
    left = a.transpose([*batch_a, *free_a, *contracted_a]).reshape(batch, -1, count)
    right = b.transpose([*batch_b, *free_b, *contracted_b]).reshape(batch, -1, count)

    def term(x: Value, y: Value) -> Value:
        return apply(to, "mul", kind, *(apply(to, "convert_element_type", kind, v) for v in (x, y)))

    sums = [
        _in_turn(to, "add", kind, [term(int(x), int(y)) for x, y in zip(row, column, strict=True)])
        for rows, columns in zip(left, right, strict=True)
        for row in rows
        for column in columns
    ]
    return (np.array(sums, dtype=np.int64).reshape(avals[0].shape),)


def _in_turn(to: Builder, name: str, kind: Type, terms: Sequence[Value], empty: float = 0.0) -> Value:
    """((x₁ + x₂) + x₃) + …"""
    if not terms:
        return to.constant(empty, kind)
    result = terms[0]
    for term in terms[1:]:
        result = apply(to, name, kind, result, term)
    return result


def reduction(name: str, empty: float) -> Row:
    """A sum, a product or an extreme over some axes. empty: of no numbers."""

    def row(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
        kind, shape = np.dtype(avals[0].dtype), avals[0].shape
        lines = _lines(operands[0], params["axes"])
        results = [_in_turn(to, name, kind, line.tolist(), empty) for line in lines]
        return (np.array(results, dtype=np.int64).reshape(shape),)

    return row


def _lines(x: Values, axes: Sequence[int]) -> Values:
    """The array as rows, each over some axes."""
    rest = [axis for axis in range(x.ndim) if axis not in axes]
    count = int(np.prod([x.shape[axis] for axis in axes], dtype=np.int64))
    return x.transpose([*rest, *sorted(axes)]).reshape(-1, count)


def running(name: str) -> Row:
    """A sum, a product or an extreme of all numbers so far, along an axis."""

    def row(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
        kind = np.dtype(avals[0].dtype)
        x = np.moveaxis(operands[0], params["axis"], -1)
        x = x[..., ::-1] if params["reverse"] else x
        result = np.empty_like(x)
        for index in np.ndindex(x.shape[:-1]):
            line: list[Value] = []
            for value in x[index].tolist():
                line.append(apply(to, name, kind, line[-1], value) if line else value)
            result[index] = line
        result = result[..., ::-1] if params["reverse"] else result
        return (np.moveaxis(result, -1, params["axis"]),)

    return row


def place_of(name: str) -> Row:
    """The index of the first extreme; of the first NaN, if there is one."""

    def row(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
        kind, given = np.dtype(params["index_dtype"]), to.type(int(operands[0].flat[0]))
        results: list[Value] = []
        for line in _lines(operands[0], params["axes"]).tolist():
            best, place = line[0], to.constant(0, kind)
            for i, value in enumerate(line[1:], start=1):
                better = apply(to, name, BOOL, value, best)
                if given.kind == "f":
                    first = apply(to, "eq", BOOL, best, best)
                    better = apply(to, "and", BOOL, first, apply(to, "or", BOOL, better, apply(to, "ne", BOOL, value, value)))
                best = to.emit("select", given, better, value, best)
                place = to.emit("select", kind, better, to.constant(i, kind), place)
            results.append(place)
        return (np.array(results, dtype=np.int64).reshape(avals[0].shape),)

    return row


def lookup(to: Builder, starts: Sequence[Value], counts: Sequence[int], table: Values) -> Value:
    """The entry of a table at an index, each part of it within its count."""
    kind = to.type(int(table.flat[0]))
    flat: Value | None = None
    for start, count in zip(starts, counts, strict=True):
        if flat is None:
            flat = start
            continue
        flat = apply(to, "add", INT32, apply(to, "mul", INT32, flat, to.constant(count, INT32)), start)
    if flat is None:
        return int(table.flat[0])
    if (known := to.number(flat)) is not None:
        return int(table.flat[int(known)])
    entries = table.ravel().tolist()
    return entries[0] if len(set(entries)) == 1 else to.emit("lookup", kind, flat, *entries)


def clamped(to: Builder, start: Value, most: int) -> Value:
    """An index, moved into 0 … most."""
    wide = apply(to, "convert_element_type", INT32, start) if to.type(start).itemsize <= INT32.itemsize else start
    kind = to.type(wide)
    inside = apply(to, "clamp", kind, to.constant(0, kind), wide, to.constant(most, kind))
    return apply(to, "convert_element_type", INT32, inside)


def _window(x: Values, offset: Sequence[int], counts: Sequence[int]) -> Values:
    """The entries of an array that an offset reaches from all starts."""
    return x[tuple(slice(first, first + count) for first, count in zip(offset, counts, strict=True))]


def _dynamic_slice(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    x, *starts = operands
    counts = [size - part + 1 for size, part in zip(x.shape, params["slice_sizes"], strict=True)]
    inside = [clamped(to, int(start), count - 1) for start, count in zip(starts, counts, strict=True)]
    result = np.empty(avals[0].shape, dtype=np.int64)
    for offset in np.ndindex(result.shape):
        result[offset] = lookup(to, inside, counts, _window(x, offset, counts))
    return (result,)


def _dynamic_update(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    del params
    x, part, *starts = operands
    kind = np.dtype(avals[0].dtype)
    counts = [size - inner + 1 for size, inner in zip(x.shape, part.shape, strict=True)]
    inside = [clamped(to, int(start), count - 1) for start, count in zip(starts, counts, strict=True)]
    result = np.array(x)
    for start in product(*map(range, counts)):
        here = _all_equal(to, inside, start)
        for offset in np.ndindex(part.shape):
            place = tuple(s + o for s, o in zip(start, offset, strict=True))
            result[place] = to.emit("select", kind, here, int(part[offset]), int(result[place]))
    return (result,)


def _all_equal(to: Builder, values: Sequence[Value], numbers: Sequence[int]) -> Value:
    """Whether each value is its number."""
    result = to.constant(True, BOOL)
    for value, number in zip(values, numbers, strict=True):
        same = apply(to, "eq", BOOL, value, to.constant(number, to.type(value)))
        result = same if to.number(result) else apply(to, "and", BOOL, result, same)
    return result


def _gathered(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
    x, indices = operands
    numbers, sizes, aval = params["dimension_numbers"], params["slice_sizes"], avals[0]
    kind = np.dtype(aval.dtype)
    hidden = {*numbers.collapsed_slice_dims, *numbers.operand_batching_dims}
    shown = [axis for axis in range(x.ndim) if axis not in hidden]
    batch_axes = [axis for axis in range(len(aval.shape)) if axis not in numbers.offset_dims]
    axes = numbers.start_index_map
    counts = [x.shape[axis] - sizes[axis] + 1 for axis in axes]
    result = np.empty(aval.shape, dtype=np.int64)
    for index in np.ndindex(aval.shape):
        batch = tuple(index[axis] for axis in batch_axes)
        starts = [int(start) for start in np.atleast_1d(indices[batch])]
        inside = [clamped(to, start, count - 1) for start, count in zip(starts, counts, strict=True)]
        ends = [(0, 1)] * x.ndim
        for axis, place in zip(shown, numbers.offset_dims, strict=True):
            ends[axis] = (index[place], 1)
        for axis, place in zip(numbers.operand_batching_dims, numbers.start_indices_batching_dims, strict=True):
            ends[axis] = (batch[place], 1)
        for axis, count in zip(axes, counts, strict=True):
            ends[axis] = (ends[axis][0] if axis in shown else 0, count)
        window = _window(x, [first for first, _ in ends], [count for _, count in ends]).transpose(
            [*axes, *(axis for axis in range(x.ndim) if axis not in axes)]
        )
        value = lookup(to, inside, counts, window)
        result[index] = value if not _fills(params) else _or_filling(to, kind, params, starts, counts, value)
    return (result,)


def _fills(params: Mapping[str, Any]) -> bool:
    return GatherScatterMode.from_any(params["mode"]) == GatherScatterMode.FILL_OR_DROP


def _or_filling(
    to: Builder, kind: Type, params: Mapping[str, Any], starts: Sequence[Value], counts: Sequence[int], value: Value
) -> Value:
    """The value, or the filling where an index is outside."""
    filling = params["fill_value"]
    if filling is None:
        filling = (
            np.nan
            if kind.kind == "f"
            else np.iinfo(kind).min
            if kind.kind == "i"
            else True
            if kind == BOOL
            else np.iinfo(kind).max
        )
    return to.emit("select", kind, _within(to, starts, counts), value, to.constant(filling, kind))


def _within(to: Builder, starts: Sequence[Value], counts: Sequence[int]) -> Value:
    """Whether each index is in 0 … count − 1."""
    result = to.constant(True, BOOL)
    for start, count in zip(starts, counts, strict=True):
        kind = to.type(start)
        above = apply(to, "ge", BOOL, start, to.constant(0, kind))
        inside = apply(to, "and", BOOL, above, apply(to, "lt", BOOL, start, to.constant(count, kind)))
        result = inside if to.number(result) else apply(to, "and", BOOL, result, inside)
    return result


def scattered(name: str) -> Row:
    """Numbers put to, or combined with, the places of indices. name: primitive that combines; "": the new number."""

    def row(to: Builder, params: Mapping[str, Any], avals: Sequence[Any], operands: list[Values]) -> Sequence[Values]:
        x, indices, updates = operands
        numbers, kind = params["dimension_numbers"], np.dtype(avals[0].dtype)
        if numbers.operand_batching_dims:
            raise UnsupportedError("with batching dimensions")
        window_axes = [axis for axis in range(x.ndim) if axis not in numbers.inserted_window_dims]
        batch_axes = [axis for axis in range(updates.ndim) if axis not in numbers.update_window_dims]
        sizes = [1] * x.ndim
        for axis, place in zip(window_axes, numbers.update_window_dims, strict=True):
            sizes[axis] = updates.shape[place]
        axes = numbers.scatter_dims_to_operand_dims
        counts = [x.shape[axis] - sizes[axis] + 1 for axis in axes]
        result = np.array(x)
        for index in np.ndindex(updates.shape):
            starts = [int(start) for start in np.atleast_1d(indices[tuple(index[axis] for axis in batch_axes)])]
            inside = starts if _drops(params) else [clamped(to, s, count - 1) for s, count in zip(starts, counts, strict=True)]
            offset = [0] * x.ndim
            for axis, place in zip(window_axes, numbers.update_window_dims, strict=True):
                offset[axis] = index[place]
            for start in product(*map(range, counts)):
                place = list(offset)
                for axis, first in zip(axes, start, strict=True):
                    place[axis] += first
                old, new = int(result[tuple(place)]), int(updates[index])
                new = apply(to, name, kind, old, new) if name else new
                result[tuple(place)] = to.emit("select", kind, _all_equal(to, inside, start), new, old)
        return (result,)

    return row


def _drops(params: Mapping[str, Any]) -> bool:
    return GatherScatterMode.from_any(params["mode"]) == GatherScatterMode.FILL_OR_DROP


ROWS: Mapping[str, Row] = {
    "reshape": moved(lambda params, aval, x: x.reshape(aval.shape)),
    "squeeze": moved(lambda params, aval, x: x.reshape(aval.shape)),
    "broadcast_in_dim": moved(_broadcast),
    "transpose": moved(lambda params, aval, x: x.transpose(params["permutation"])),
    "slice": moved(_sliced),
    "rev": moved(lambda params, aval, x: np.flip(x, params["dimensions"])),
    "concatenate": _concatenated,
    "pad": _padded,
    "iota": _counted,
    "split": _split,
    "stack": _stacked,
    "unstack": _unstacked,
    "tile": moved(lambda params, aval, x: np.tile(x, params["reps"])),
    "broadcast_to": moved(lambda params, aval, x: np.broadcast_to(x, aval.shape)),
    "dot_general": _products,
    "reduce_sum": reduction("add", 0.0),
    "reduce_prod": reduction("mul", 1.0),
    "reduce_max": reduction("max", -np.inf),
    "reduce_min": reduction("min", np.inf),
    "reduce_and": reduction("and", True),
    "reduce_or": reduction("or", False),
    "reduce_xor": reduction("xor", 0),
    "cumsum": running("add"),
    "cumprod": running("mul"),
    "cummax": running("max"),
    "cummin": running("min"),
    "argmax": place_of("gt"),
    "argmin": place_of("lt"),
    "dynamic_slice": _dynamic_slice,
    "dynamic_update_slice": _dynamic_update,
    "gather": _gathered,
    "scatter": scattered(""),
    "scatter-add": scattered("add"),
    "scatter-mul": scattered("mul"),
    "scatter-sub": scattered("sub"),
    "scatter-min": scattered("min"),
    "scatter-max": scattered("max"),
}
"""Primitive → what it does with the values of its operands."""
