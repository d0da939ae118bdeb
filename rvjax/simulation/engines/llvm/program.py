"""Scalar programs: what a jaxpr computes for a single sample, number by number.

A value is a whole number, its index in `Program.types`. An operation computes values from others; its code is an instruction of
`rvjax.simulation.engines.llvm.text`. Equal operations of a region are computed once. A region is a straight line of operations;
a branch or a loop holds regions.

A value is uniform if it is the same in every lane: a constant, the number of the step, and what follows from these.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Value = int
Type = np.dtype[Any]

BOOL, INT32, UINT32 = np.dtype(np.bool_), np.dtype(np.int32), np.dtype(np.uint32)
FLOAT32, FLOAT64 = np.dtype(np.float32), np.dtype(np.float64)


class UnsupportedError(Exception):
    """A jaxpr with a primitive that has no row in the tables, or a form of it that has none. The message names it."""


@dataclass(frozen=True, slots=True)
class Operation:
    """results: the values that it computes. code: the instruction. operands: values. detail: numbers that belong to the code.
    regions: of a branch or a loop."""

    results: tuple[Value, ...]
    code: str
    operands: tuple[Value, ...]
    detail: Any = None
    regions: tuple[Region, ...] = ()


@dataclass(frozen=True, slots=True)
class Region:
    """A straight line of operations. arguments: values that it gets from its loop. results: values that it gives."""

    arguments: tuple[Value, ...]
    operations: tuple[Operation, ...]
    results: tuple[Value, ...]


@dataclass
class Program:
    """types, uniform: of every value. constants: value → number. body: of inputs and results of the whole program."""

    types: list[Type] = field(default_factory=list[Type])
    uniform: list[bool] = field(default_factory=list[bool])
    constants: dict[Value, Any] = field(default_factory=dict[Value, Any])
    body: Region = Region((), (), ())

    @property
    def operations(self) -> int:
        """The operations, those of its regions included."""
        return sum(1 for _ in walk(self.body))

    def digest(self) -> str:
        """SHA-256 of all that it computes."""
        text = hashlib.sha256()
        for value, number in self.constants.items():
            text.update(f"{value} {self.types[value]} {np.asarray(number).tobytes().hex()}\n".encode())
        for operation in walk(self.body):
            types = [self.types[value].str for value in operation.results]
            text.update(f"{operation.results} {types} {operation.code} {operation.operands} {operation.detail!r}\n".encode())
            text.update(f"{[(region.arguments, region.results) for region in operation.regions]}\n".encode())
        text.update(
            f"{self.body.arguments} {[self.types[value].str for value in self.body.arguments]} {self.body.results}".encode()
        )
        return text.hexdigest()


def walk(region: Region) -> Iterator[Operation]:
    """The operations of a region and of the regions in it."""
    for operation in region.operations:
        yield operation
        for inner in operation.regions:
            yield from walk(inner)


class Builder:
    """Writes a program, operation by operation."""

    def __init__(self) -> None:
        self.program = Program()
        self._lines: list[list[Operation]] = [[]]
        self._known: list[dict[Any, tuple[Value, ...]]] = [{}]
        self._constants: dict[Any, Value] = {}

    def new(self, kind: Type, uniform: bool) -> Value:
        """A value that an input or an operation gives."""
        self.program.types.append(kind)
        self.program.uniform.append(uniform)
        return len(self.program.types) - 1

    def type(self, value: Value) -> Type:
        """Its type."""
        return self.program.types[value]

    def constant(self, number: Any, kind: Type) -> Value:
        """A number of a type; a NaN has its usual bits."""
        cast = np.asarray(number).astype(kind)[()]
        if kind.kind == "f" and np.isnan(cast):
            cast = kind.type(np.nan)
        key = (kind.str, cast.tobytes())
        if key not in self._constants:
            self._constants[key] = self.new(kind, True)
            self.program.constants[self._constants[key]] = cast
        return self._constants[key]

    def number(self, value: Value) -> Any:
        """The number of a constant; None of any other value."""
        return self.program.constants.get(value)

    def emit(self, code: str, kind: Type, *operands: Value, detail: Any = None) -> Value:
        """The value of an operation."""
        numbers = [self.program.constants.get(value) for value in operands]
        if code in FOLDED and numbers and all(number is not None for number in numbers):
            with np.errstate(all="ignore"):
                return self.constant(FOLDED[code](*numbers), kind)
        if code == "select" and numbers[0] is not None:
            return operands[1] if numbers[0] else operands[2]
        if code == "select" and operands[1] == operands[2]:
            return operands[1]
        key = (code, kind.str, operands, detail)
        for known in reversed(self._known):
            if key in known:
                return known[key][0]
        value = self.new(kind, all(self.program.uniform[operand] for operand in operands))
        self._append(Operation((value,), code, operands, detail), key)
        return value

    def structured(
        self,
        code: str,
        kinds: Sequence[Type],
        uniform: Sequence[bool],
        operands: Sequence[Value],
        regions: Sequence[Region],
        detail: Any = None,
    ) -> tuple[Value, ...]:
        """The values of a branch or a loop."""
        results = tuple(self.new(kind, same) for kind, same in zip(kinds, uniform, strict=True))
        self._append(Operation(results, code, tuple(operands), detail, tuple(regions)), None)
        return results

    def _append(self, operation: Operation, key: Any) -> None:
        self._lines[-1].append(operation)
        if key is not None:
            self._known[-1][key] = operation.results

    @contextmanager
    def region(self) -> Iterator[Callable[[Sequence[Value], Sequence[Value]], Region]]:
        """Operations inside go into a region, which is made by the function that this gives: (arguments, results) → region."""
        self._lines.append([])
        self._known.append({})
        line = self._lines[-1]
        try:
            yield lambda arguments, results: Region(tuple(arguments), tuple(line), tuple(results))
        finally:
            self._lines.pop()
            self._known.pop()

    def finished(self, inputs: Sequence[Value], results: Sequence[Value]) -> Program:
        """The program, without what no result needs."""
        self.program.body = needed(Region(tuple(inputs), tuple(self._lines[0]), tuple(results)))
        return self.program


def needed(region: Region, more: frozenset[Value] = frozenset()) -> Region:
    """The region without operations that no result needs. more: further values that are needed."""
    wanted = set(region.results) | more
    kept: list[Operation] = []
    for operation in reversed(region.operations):
        if not wanted.intersection(operation.results):
            continue
        inner = tuple(needed(part) for part in operation.regions)
        lean = Operation(operation.results, operation.code, operation.operands, operation.detail, inner)
        kept.append(lean)
        wanted.update(operation.operands)
        for part in inner:
            wanted |= outside(part)
    return Region(region.arguments, tuple(reversed(kept)), region.results)


def outside(region: Region) -> set[Value]:
    """The values that a region uses and does not compute."""
    own, used = set(region.arguments), set(region.results)
    for operation in walk(region):
        own.update(operation.results)
        used.update(operation.operands)
        for inner in operation.regions:
            own.update(inner.arguments)
            used.update(inner.results)
    return used - own


FOLDED: Mapping[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "and": np.bitwise_and,
    "or": np.bitwise_or,
    "xor": np.bitwise_xor,
    "icmp eq": np.equal,
    "icmp ne": np.not_equal,
    "icmp slt": np.less,
    "icmp sle": np.less_equal,
    "icmp sgt": np.greater,
    "icmp sge": np.greater_equal,
    "icmp ult": np.less,
    "icmp ule": np.less_equal,
    "icmp ugt": np.greater,
    "icmp uge": np.greater_equal,
    "fadd": np.add,
    "fsub": np.subtract,
    "fmul": np.multiply,
    "fdiv": np.divide,
    "fneg": np.negative,
    "fabs": np.abs,
    "sqrt": np.sqrt,
    "floor": np.floor,
    "rint": np.rint,
    "fcmp oeq": np.equal,
    "fcmp une": np.not_equal,
    "fcmp olt": np.less,
    "fcmp ole": np.less_equal,
    "fcmp ogt": np.greater,
    "fcmp oge": np.greater_equal,
}
"""Instructions that are computed at once if all operands are constants. IEEE 754 fixes each of these results."""
