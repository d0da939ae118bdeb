"""A scalar program as LLVM assembly: a function that flies groups of lanes.

    for each group of lanes:   for k = first … last − 1:   results ← program(numbers, carry, k)

A group's numbers and carry lie side by side in memory, a vector per leaf, so the state of a group stays in the first cache while
it flies all its steps. There is no flag that lets LLVM round differently from IEEE 754: nothing is contracted or reassociated.
The floating-point mode (round to nearest, subnormal numbers are numbers) is set on entry and put back on return.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from rvjax.simulation.engines.llvm.instructions import NAMES, Writer
from rvjax.simulation.engines.llvm.program import Program, Region, Type
from rvjax.simulation.engines.llvm.structures import write


class Mode(NamedTuple):
    """The floating-point mode of an instruction set: declarations, and lines that set it and put it back."""

    declared: tuple[str, ...]
    set: tuple[str, ...]
    restored: tuple[str, ...]


MODES: Mapping[str, Mode] = {
    "x86_64": Mode(
        ("declare void @llvm.x86.sse.stmxcsr(ptr)", "declare void @llvm.x86.sse.ldmxcsr(ptr)"),
        (
            "  %mode = alloca i32",
            "  %wanted = alloca i32",
            "  call void @llvm.x86.sse.stmxcsr(ptr %mode)",
            "  store i32 8064, ptr %wanted",  # 0x1F80: round to nearest, all exceptions masked, no flushing to zero
            "  call void @llvm.x86.sse.ldmxcsr(ptr %wanted)",
        ),
        ("  call void @llvm.x86.sse.ldmxcsr(ptr %mode)",),
    ),
    "aarch64": Mode(
        ("declare i64 @llvm.aarch64.get.fpcr()", "declare void @llvm.aarch64.set.fpcr(i64)"),
        ("  %mode = call i64 @llvm.aarch64.get.fpcr()", "  call void @llvm.aarch64.set.fpcr(i64 0)"),
        ("  call void @llvm.aarch64.set.fpcr(i64 %mode)",),
    ),
}
"""By instruction set. Another one flies in the mode of its thread."""


@dataclass
class Kernel:
    """What a function of machine code gets and gives. numbers, carry: how many of the program's inputs come from each. lanes: of
    a group. real: type of numbers and carry in memory. out: type of the results in memory."""

    program: Program
    numbers: int
    carry: int
    lanes: int
    real: Type
    out: Type


def assembly(kernel: Kernel, name: str, attributes: str, machine: str) -> str:
    """The text of a function `name(groups, first, last, numbers, carry, out)`. machine: instruction set."""
    writer, body = Writer(kernel.program, kernel.lanes), kernel.program.body
    _read_inputs(writer, kernel, body)
    write(writer, body)
    _write_results(writer, kernel, body)
    mode = MODES.get(machine, Mode((), (), ()))
    sizes = {"n": ("numbers", kernel.numbers, kernel.real), "c": ("carry", kernel.carry, kernel.real)}
    pointers = [
        line
        for letter, (buffer, count, kind) in (sizes | {"o": ("out", len(body.results), kernel.out)}).items()
        for line in (
            f"  %g{letter} = mul i64 %g, {count * kernel.lanes}",
            f"  %{letter}p = getelementptr {NAMES[kind.name]}, ptr %{buffer}, i64 %g{letter}",
        )
    ]
    return "\n".join([
        *(*writer.tables, *writer.declared.values(), *mode.declared),
        f"define void @{name}(i64 %groups, i32 %first, i32 %last, ptr noalias %numbers, ptr %carry, ptr %out) #0 {{",
        *("entry:", *writer.head, *mode.set, "  br label %group"),
        *("group:", "  %g = phi i64 [0, %entry], [%g1, %groupend]", *pointers, "  br label %step"),
        *("step:", "  %k = phi i32 [%first, %group], [%k1, %stepend]", *writer.lines, "  br label %stepend"),
        *("stepend:", "  %k1 = add i32 %k, 1", "  %more = icmp slt i32 %k1, %last"),
        "  br i1 %more, label %step, label %groupend",
        *("groupend:", "  %g1 = add i64 %g, 1", "  %others = icmp slt i64 %g1, %groups"),
        "  br i1 %others, label %group, label %done",
        *("done:", *mode.restored, "  ret void", "}"),
        f'attributes #0 = {{ nounwind "stackrealign" {attributes} }}',
        "",
    ])  # fmt: skip


def _read_inputs(writer: Writer, kernel: Kernel, body: Region) -> None:
    """Loads numbers and carry of the group; the number of the step is the same in every lane."""
    for place, value in enumerate(body.arguments):
        if place >= kernel.numbers + kernel.carry:
            writer.names[value] = writer.spread("%k", writer.type(value))
            continue
        base, index = ("%np", place) if place < kernel.numbers else ("%cp", place - kernel.numbers)
        pointer = writer.new(f"getelementptr {NAMES[kernel.real.name]}, ptr {base}, i64 {index * kernel.lanes}")
        align = kernel.real.itemsize * kernel.lanes
        writer.names[value] = writer.new(f"load {writer.vector(kernel.real)}, ptr {pointer}, align {align}")


def _write_results(writer: Writer, kernel: Kernel, body: Region) -> None:
    """Stores the results of the group, as real numbers."""
    out, align = writer.vector(kernel.out), kernel.out.itemsize * kernel.lanes
    for place, value in enumerate(body.results):
        text, kind = writer.name(value), writer.type(value)
        if kind != kernel.out:
            wider = "fpext" if kind.itemsize < kernel.out.itemsize else "fptrunc"
            code = {"f": wider, "i": "sitofp"}.get(kind.kind, "uitofp")
            text = writer.new(f"{code} {writer.vector(kind)} {text} to {out}")
        pointer = writer.new(f"getelementptr {NAMES[kernel.out.name]}, ptr %op, i64 {place * kernel.lanes}")
        writer.lines.append(f"  store {out} {text}, ptr {pointer}, align {align}")
