"""Operations that are more than an instruction: tables that are looked up, branches and loops."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rvjax.simulation.engines.llvm.instructions import NAMES, Writer, literal, suffix
from rvjax.simulation.engines.llvm.program import BOOL, Operation, Region, Type, Value

SELECTED = 16
"""Longest table of numbers that is looked up by comparing the index; truth values always are."""


def write(writer: Writer, region: Region) -> None:
    """Writes the operations of a region."""
    for operation in region.operations:
        if (structure := _STRUCTURES.get(operation.code)) is not None:
            structure(writer, operation)
        else:
            writer.names[operation.results[0]] = writer.instruction(operation)


def _lookup(writer: Writer, operation: Operation) -> None:
    """An entry of a table at an index."""
    index, *entries = operation.operands
    kind, numbers = writer.type(operation.results[0]), writer.program.constants
    if len(entries) <= SELECTED or kind == BOOL:
        text = writer.name(entries[-1])
        for place in reversed(range(len(entries) - 1)):
            here = writer.new(f"icmp eq {writer.vector(writer.type(index))} {writer.name(index)}, splat (i32 {place})")
            vector = writer.vector(kind)
            text = writer.new(f"select {writer.vector(BOOL)} {here}, {vector} {writer.name(entries[place])}, {vector} {text}")
        writer.names[operation.results[0]] = text
        return
    if all(entry in numbers for entry in entries):
        writer.names[operation.results[0]] = _constant_table(writer, index, [numbers[entry] for entry in entries], kind)
        return
    table, vector = writer.memory(len(entries), kind), writer.vector(kind)
    for place, entry in enumerate(entries):
        pointer = writer.new(f"getelementptr {vector}, ptr {table}, i64 {place}")
        writer.lines.append(f"  store {vector} {writer.name(entry)}, ptr {pointer}")
    writer.names[operation.results[0]] = _each_lane(
        writer, index, kind, lambda at, lane: writer.new(f"getelementptr {vector}, ptr {table}, i32 {at}, i32 {lane}")
    )


def _constant_table(writer: Writer, index: Value, numbers: Sequence[Any], kind: Type) -> str:
    """A table of constants, read lane by lane."""
    scalar, name = NAMES[kind.name], f"@table{len(writer.tables)}"
    listed = ", ".join(f"{scalar} {literal(number, kind)}" for number in numbers)
    text = f"private unnamed_addr constant [{len(numbers)} x {scalar}] [{listed}]"
    known = next((line.partition(" = ")[0] for line in writer.tables if line.endswith(text)), None)
    if known is None:
        writer.tables.append(f"{name} = {text}")
    return _each_lane(writer, index, kind, lambda at, lane: writer.new(f"getelementptr {scalar}, ptr {known or name}, i32 {at}"))


def _each_lane(writer: Writer, index: Value, kind: Type, pointer: Callable[[str, int], str]) -> str:
    """A load per lane."""
    vector, scalar, given = writer.vector(kind), NAMES[kind.name], writer.vector(writer.type(index))
    text = "poison"
    for lane in range(writer.lanes):
        at = writer.new(f"extractelement {given} {writer.name(index)}, i32 {lane}")
        number = writer.new(f"load {scalar}, ptr {pointer(at, lane)}")
        text = writer.new(f"insertelement {vector} {text}, {scalar} {number}, i32 {lane}")
    return text


def _branch(writer: Writer, operation: Operation) -> None:
    """One of two regions, the same in all lanes."""
    labels, end = [writer.label(), writer.label()], writer.label()
    condition = writer.new(f"extractelement {writer.vector(BOOL)} {writer.name(operation.operands[0])}, i32 0")
    writer.lines.append(f"  br i1 {condition}, label %{labels[0]}, label %{labels[1]}")
    sides: list[tuple[list[str], str]] = []
    for label, region in zip(labels, operation.regions, strict=True):
        writer.start(label)
        write(writer, region)
        sides.append(([writer.name(value) for value in region.results], writer.block))
        writer.lines.append(f"  br label %{end}")
    writer.start(end)
    for place, value in enumerate(operation.results):
        choices = ", ".join(f"[{texts[place]}, %{block}]" for texts, block in sides)
        writer.names[value] = writer.new(f"phi {writer.vector(writer.type(value))} {choices}")


def _slots(writer: Writer, operation: Operation) -> list[str]:
    """Memory for the carry of a loop, with its first values."""
    slots: list[str] = []
    for value in operation.operands:
        slots.append(writer.memory(1, writer.type(value)))
        writer.lines.append(f"  store {writer.vector(writer.type(value))} {writer.name(value)}, ptr {slots[-1]}")
    return slots


def _loaded(writer: Writer, values: Sequence[Value], slots: Sequence[str]) -> None:
    for value, slot in zip(values, slots, strict=True):
        writer.names[value] = writer.new(f"load {writer.vector(writer.type(value))}, ptr {slot}")


def _stored(writer: Writer, values: Sequence[Value], slots: Sequence[str]) -> None:
    for value, slot in zip(values, slots, strict=True):
        writer.lines.append(f"  store {writer.vector(writer.type(value))} {writer.name(value)}, ptr {slot}")


def _loop(writer: Writer, operation: Operation) -> None:
    """A region, a fixed number of times."""
    (region,), slots = operation.regions, _slots(writer, operation)
    begin, end, before = writer.label(), writer.label(), writer.block
    index, following, more = (f"%{letter}{begin}" for letter in "ijm")
    writer.lines.append(f"  br label %{begin}")
    writer.start(begin)
    place = len(writer.lines)
    writer.lines.append("")
    writer.names[region.arguments[0]] = writer.spread(index, writer.type(region.arguments[0]))
    _loaded(writer, region.arguments[1:], slots)
    write(writer, region)
    _stored(writer, region.results, slots)
    writer.lines[place] = f"  {index} = phi i32 [0, %{before}], [{following}, %{writer.block}]"
    writer.lines += [
        f"  {following} = add i32 {index}, 1",
        f"  {more} = icmp slt i32 {following}, {operation.detail}",
        f"  br i1 {more}, label %{begin}, label %{end}",
    ]
    writer.start(end)
    _loaded(writer, operation.results, slots)


def _while(writer: Writer, operation: Operation) -> None:
    """A region, as long as its condition holds in a lane."""
    (region,), slots = operation.regions, _slots(writer, operation)
    begin, again, end = writer.label(), writer.label(), writer.label()
    writer.lines.append(f"  br label %{begin}")
    writer.start(begin)
    _loaded(writer, region.arguments, slots)
    write(writer, region)
    goes = writer.call(
        f"llvm.vector.reduce.or.{suffix(BOOL, writer.lanes)}", "i1", (writer.vector(BOOL), writer.name(region.results[0]))
    )
    writer.lines.append(f"  br i1 {goes}, label %{again}, label %{end}")
    writer.start(again)
    _stored(writer, region.results[1:], slots)
    writer.lines.append(f"  br label %{begin}")
    writer.start(end)
    _loaded(writer, operation.results, slots)


_STRUCTURES: Mapping[str, Callable[[Writer, Operation], None]] = {
    "lookup": _lookup,
    "branch": _branch,
    "loop": _loop,
    "while": _while,
}
