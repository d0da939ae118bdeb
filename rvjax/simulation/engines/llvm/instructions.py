"""Instructions of LLVM for the operations of a scalar program: every value is a vector with an entry per lane."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from typing import Any

from rvjax.simulation.engines.llvm.program import BOOL, Operation, Program, Type, Value

NAMES = {
    "float64": "double",
    "float32": "float",
    "bool": "i1",
    "int8": "i8",
    "uint8": "i8",
    "int16": "i16",
    "uint16": "i16",
    "int32": "i32",
    "uint32": "i32",
    "int64": "i64",
    "uint64": "i64",
}
"""Type of NumPy → type of LLVM."""


@dataclass
class Writer:
    """Writes lines of a function. program: whose values they compute. lanes: of a vector. head: lines of the entry block. tables:
    constants of the module. declared: functions of LLVM that are called."""

    program: Program
    lanes: int
    lines: list[str] = field(default_factory=list[str])
    head: list[str] = field(default_factory=list[str])
    tables: list[str] = field(default_factory=list[str])
    declared: dict[str, str] = field(default_factory=dict[str, str])
    names: dict[Value, str] = field(default_factory=dict[Value, str])
    count: int = 0
    block: str = "step"

    def vector(self, kind: Type) -> str:
        """The LLVM type of a value."""
        return f"<{self.lanes} x {NAMES[kind.name]}>"

    def type(self, value: Value) -> Type:
        """Its type."""
        return self.program.types[value]

    def spread(self, scalar: str, kind: Type) -> str:
        """The same number in every lane."""
        vector, n = self.vector(kind), self.lanes
        first = self.new(f"insertelement {vector} poison, {NAMES[kind.name]} {scalar}, i32 0")
        return self.new(f"shufflevector {vector} {first}, {vector} poison, <{n} x i32> zeroinitializer")

    def new(self, expression: str) -> str:
        """The name of a new result."""
        self.count += 1
        name = f"%t{self.count}"
        self.lines.append(f"  {name} = {expression}")
        return name

    def label(self) -> str:
        """The name of a new block."""
        self.count += 1
        return f"b{self.count}"

    def start(self, label: str) -> None:
        """Begins a block."""
        self.lines.append(f"{label}:")
        self.block = label

    def name(self, value: Value) -> str:
        """The text of a value."""
        if value not in self.names:
            self.names[value] = self._constant(self.program.constants[value], self.type(value))
        return self.names[value]

    def _constant(self, number: Any, kind: Type) -> str:
        return f"splat ({NAMES[kind.name]} {literal(number, kind)})"

    def call(self, name: str, result: str, *operands: tuple[str, str]) -> str:
        """The result of an intrinsic. operands: (type, text)."""
        self.declared[name] = f"declare {result} @{name}({', '.join(kind for kind, _ in operands)})"
        return self.new(f"call {result} @{name}({', '.join(f'{kind} {text}' for kind, text in operands)})")

    def instruction(self, operation: Operation) -> str:
        """Writes an operation and returns the name of its result."""
        code, kind = operation.code, self.type(operation.results[0])
        given = self.type(operation.operands[0])
        texts = [self.name(value) for value in operation.operands]
        vector, out = self.vector(given), self.vector(kind)
        if code == "same":
            return texts[0]
        if code == "select":
            truth = self.vector(BOOL)
            return self.new(f"select {truth} {texts[0]}, {out} {texts[1]}, {out} {texts[2]}")
        if code in INTRINSICS:
            return self.call(f"llvm.{code}.{suffix(kind, self.lanes)}", out, (vector, texts[0]))
        if code.endswith(".sat"):
            name = f"llvm.{code}.{suffix(kind, self.lanes)}.{suffix(given, self.lanes)}"
            return self.call(name, out, (vector, texts[0]))
        if code in CONVERSIONS:
            return self.new(f"{code} {vector} {texts[0]} to {out}")
        return self.new(f"{code} {vector} {', '.join(texts)}")

    def memory(self, count: int, kind: Type) -> str:
        """Memory for some values of a type."""
        self.count += 1
        name = f"%m{self.count}"
        self.head.append(f"  {name} = alloca [{count} x {self.vector(kind)}], align {kind.itemsize * self.lanes or 8}")
        return name


INTRINSICS = {"sqrt", "fabs", "floor", "ceil", "rint", "round"}
CONVERSIONS = {"fpext", "fptrunc", "sitofp", "uitofp", "zext", "sext", "trunc", "bitcast"}


def suffix(kind: Type, lanes: int) -> str:
    """The ending of an intrinsic's name: `v8f64`."""
    return f"v{lanes}{'f' if kind.kind == 'f' else 'i'}{1 if kind == BOOL else 8 * kind.itemsize}"


def literal(number: Any, kind: Type) -> str:
    """A number as LLVM reads it: a float by its bits."""
    if kind.kind == "f":
        return f"0x{struct.unpack('<Q', struct.pack('<d', float(number)))[0]:016X}"
    return str(bool(number)).lower() if kind == BOOL else str(int(number))
