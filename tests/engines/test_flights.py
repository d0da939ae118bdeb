"""Whole flights with the engine `llvm`: bit for bit those of an interpreter in NumPy, on every kind of processor."""

from __future__ import annotations

import ctypes
import platform
import threading
from concurrent.futures import CancelledError
from functools import partial
from pathlib import Path
from typing import Any

import jax
import llvmlite.binding as llvm
import numpy as np
import pytest

from rvjax.physics import elementary
from rvjax.simulation import closed_loop, flight, jax_config
from rvjax.simulation.batch import Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines.llvm.elementwise import ELEMENTARY
from rvjax.simulation.engines.llvm.engine import PAYS, LlvmChunk, LlvmEngine
from rvjax.simulation.engines.llvm.machine_code import Target, host
from rvjax.simulation.problem import Problem, load
from tests.engines.machine import same
from tests.engines.targets import TARGETS, can_run
from tests.oracles.interpreter import Interpreted, interpreted
from tests.physics.test_hulls import CAMPAIGN as COLLISIONS
from tests.physics.test_hulls import SHAPES
from tests.short import CAMPAIGN

FOLDER = Path(__file__).parents[2] / "campaigns"
FIRST = ("docking-faulted.yaml", "navigation.yaml")
"""Faults, adaptation and a differentiator; random numbers, memories and a sampled controller."""

GUIDANCE = (
    "{use: corridor}",
    "{use: waypoints, points: [{frame: lvlh, at_m: [9, 0, 5], speed_m_s: 0.3}, {frame: port, at_m: [0, 1, 0], speed_m_s: 0.1}]}",
)

OTHERS = sorted({str(path.relative_to(FOLDER)) for path in FOLDER.rglob("*.yaml")} - {*FIRST})
FUNCTIONS = {name: getattr(elementary, name) for name in ELEMENTARY}
SAMPLES, STEPS = 12, 7


def problem(name: str) -> Problem:
    """A shipped campaign, in a process that is configured for it."""
    found = load(FOLDER / name)
    jax_config.configure(found.spec.precision)
    return found


def flown(found: Problem, drawn: Any, steps: int, target: Target | None = None) -> list[Any]:
    """Everything that passes on after some steps, and everything that `finish` gives there."""
    chunk = LlvmEngine(found.loop, found.metrics, target).begin(drawn, steps=PAYS)
    chunk.advance(0, steps)
    return [np.asarray(x) for x in jax.tree.leaves((chunk.numbers_and_carry()[1], chunk.finish(steps)))]


def by_numpy(found: Problem, drawn: Any, steps: int) -> list[Any]:
    """The same by the interpreter."""
    evaluate = partial(closed_loop.evaluate, found.loop)
    numbers = jax.tree.map(partial(np.asarray, dtype=found.spec.precision), drawn)
    carry = interpreted(partial(flight.begin, found.loop, found.metrics), FUNCTIONS, numbers)
    step, finish = (partial(function, evaluate, found.metrics) for function in (flight.step, flight.finish))
    stepped = Interpreted(step, FUNCTIONS, numbers, carry, 0)
    for k in range(steps):
        carry = stepped(numbers, carry, k)
    return jax.tree.leaves((carry, interpreted(finish, FUNCTIONS, numbers, carry, steps)))


def same_all(ours: list[Any], theirs: list[Any]) -> bool:
    """Equal bits in every number; NaN where the other has NaN."""
    return all(same(a, b) for a, b in zip(ours, theirs, strict=True))


@pytest.mark.parametrize("name", FIRST)
def test_a_flight_is_that_of_the_interpreter(name: str) -> None:
    """Every number after some steps. Kills: a wrong instruction, a contracted product, a sum in another order, a function of a C
    library."""
    found = problem(name)
    _, drawn = Draws.of(found, np.arange(SAMPLES))
    assert same_all(flown(found, drawn, STEPS), by_numpy(found, drawn, STEPS))


@pytest.mark.parametrize("shapes", SHAPES)
def test_hulls_are_those_of_the_interpreter(shapes: str, tmp_path: Path) -> None:
    """Balls and boxes, a keep-out zone, a corridor with a radius and an end. Kills: an
    instruction of the clearance that the interpreter sees otherwise."""
    path = tmp_path / "hulls.yaml"
    target, pursuer = SHAPES[shapes]
    path.write_text(COLLISIONS.replace("TARGET", target).replace("PURSUER", pursuer))
    found = load(path)
    jax_config.configure(found.spec.precision)
    _, drawn = Draws.of(found, np.arange(SAMPLES))
    assert {"hull_clearance_m", "keep_out_violation_s"} <= found.metric_columns.keys()
    assert same_all(flown(found, drawn, STEPS), by_numpy(found, drawn, STEPS))


@pytest.mark.parametrize("guidance", GUIDANCE)
def test_a_flight_with_guidance_is_that_of_the_interpreter(guidance: str) -> None:
    """The same with a reference point that moves. Kills: a memory or a turning that the engine computes in another way."""
    found = load(CAMPAIGN, [f"guidance={guidance}", "controller={use: pd-plus}"])
    jax_config.configure(found.spec.precision)
    _, drawn = Draws.of(found, np.arange(SAMPLES))
    assert same_all(flown(found, drawn, STEPS), by_numpy(found, drawn, STEPS))


@pytest.mark.parametrize("name", OTHERS)
def test_every_shipped_flight_is_that_of_the_interpreter(name: str) -> None:
    """The same in the other shipped campaigns."""
    test_a_flight_is_that_of_the_interpreter(name)


@pytest.mark.parametrize("kind", TARGETS)
@pytest.mark.parametrize("name", FIRST)
def test_the_processor_changes_no_bit(name: str, kind: str) -> None:
    """A second of flight with the instructions of several processors and 2, 4, 8 and 16 lanes. Kills: fused multiplication and
    addition where a processor has it, results that depend on the group of a lane."""
    can_run(kind)
    found = problem(name)
    _, drawn = Draws.of(found, np.arange(37))
    steps = 60
    assert same_all(flown(found, drawn, steps), flown(found, drawn, steps, TARGETS[kind]))


@pytest.mark.parametrize("kind", TARGETS)
@pytest.mark.parametrize("name", OTHERS)
def test_the_processor_changes_no_bit_of_any_shipped_flight(name: str, kind: str) -> None:
    """The same in the other shipped campaigns."""
    test_the_processor_changes_no_bit(name, kind)


@pytest.mark.parametrize("name", FIRST)
def test_optimised_code_flies_the_same_bits(name: str) -> None:
    """Of flights that last, and of those that do not. Kills: an optimisation that rounds in another way; flights that are never
    optimised, or all of them."""
    found = problem(name)
    _, drawn = Draws.of(found, np.arange(24))
    engine = LlvmEngine(found.loop, found.metrics)
    flights = []
    for steps in (40, PAYS):
        chunk = engine.begin(drawn, steps=steps)
        chunk.advance(0, 40)
        flights.append(jax.tree.leaves(chunk.numbers_and_carry()[1]))
    assert same_all(*flights)
    assert set(engine.flight(drawn)._compiled) == {("begin", 0), ("advance", 0), ("advance", 2)}


@pytest.mark.parametrize("samples", [1, 24, 61])
def test_threads_change_no_bit(samples: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a chunk that flies on several: more of them than groups, and groups that they cannot share evenly. Kills: a group that
    no thread flies, or two; a thread with the numbers of another."""
    monkeypatch.setattr("rvjax.simulation.engines.llvm.engine.WORTH_A_THREAD", 1)
    found = problem("quickstart.yaml")
    _, drawn = Draws.of(found, np.arange(samples))
    engine = LlvmEngine(found.loop, found.metrics)
    flights = []
    for threads in (1, 2, 3, 16):
        chunk = engine.begin(drawn)
        chunk.advance(0, 20, threads)
        chunk.advance(20, 30, threads)
        flights.append(jax.tree.leaves(chunk.numbers_and_carry()[1]))
    assert all(same_all(flights[0], flight) for flight in flights[1:])


def test_chunks_share_the_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chunk alone flies on all threads of its flyer, two share them. Kills: a worker of several on a machine that takes all
    cores; chunks that leave cores idle; a count that does not go down when a chunk ends, or fails."""
    used: list[int] = []
    monkeypatch.setattr(LlvmChunk, "advance", lambda _, first, last, threads: used.append(threads))
    found = problem("quickstart.yaml")
    flyer = Flyer(LlvmEngine(found.loop, found.metrics), threads=5)
    _, drawn = Draws.of(found, np.arange(3))
    flyer.fly(drawn, 10, 10)
    flyer.watch(drawn, [5], lambda *_: used.append(0) or flyer.fly(drawn, 10, 10) is None)
    flyer.stop()
    with pytest.raises(CancelledError):
        flyer.fly(drawn, 10, 10)
    flyer.watch(drawn, [5], lambda *_: False)
    assert used == [5, 5, 0, 2, 5]


def test_the_step_is_compiled_ahead() -> None:
    """In a thread, at the level that the announced steps need, and not again. Kills: a step that is compiled twice; an error in
    the thread that nobody sees."""
    found = problem("quickstart.yaml")
    _, drawn = Draws.of(found, np.arange(3))
    engine = LlvmEngine(found.loop, found.metrics)
    before = set(threading.enumerate())
    engine.prepare(drawn, PAYS)
    for thread in set(threading.enumerate()) - before:
        thread.join()
    assert set(engine.flight(drawn)._compiled) == {("advance", 2)}
    engine.begin(drawn).advance(0, 10)
    assert set(engine.flight(drawn)._compiled) == {("begin", 0), ("advance", 2)}


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="the registers are those of x86")
def test_the_mode_of_the_thread_changes_no_bit() -> None:
    """A thread that rounds towards zero and takes subnormal numbers for 0 flies the same bits, and keeps its mode. Kills: a
    flight that trusts the mode of its thread."""
    found = problem("quickstart.yaml")
    _, drawn = Draws.of(found, np.arange(8))
    engine = LlvmEngine(found.loop, found.metrics)
    usual = engine.begin(drawn)
    usual.advance(0, 20)
    set_mode, get_mode = _modes()
    before = get_mode()
    chunk = engine.begin(drawn)
    set_mode(0x1F80 | 0x8040 | 0x6000)
    try:
        chunk.advance(0, 20)
        kept = get_mode()
    finally:
        set_mode(before)
    assert kept & 0xFFC0 == 0xFFC0
    assert same_all(*(jax.tree.leaves(flying.numbers_and_carry()[1]) for flying in (usual, chunk)))


def _modes() -> tuple[Any, Any]:
    """(sets the floating-point mode of the thread, gives it), by machine code."""
    text = """
    declare void @llvm.x86.sse.ldmxcsr(ptr)
    declare void @llvm.x86.sse.stmxcsr(ptr)
    define void @set(i32 %x) { %p = alloca i32
      store i32 %x, ptr %p
      call void @llvm.x86.sse.ldmxcsr(ptr %p)
      ret void }
    define i32 @get() { %p = alloca i32
      call void @llvm.x86.sse.stmxcsr(ptr %p)
      %x = load i32, ptr %p
      ret i32 %x }
    """
    host()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(text), llvm.Target.from_default_triple().create_target_machine())
    engine.finalize_object()
    _KEPT.append(engine)
    setter = ctypes.CFUNCTYPE(None, ctypes.c_uint32)(engine.get_function_address("set"))
    return setter, ctypes.CFUNCTYPE(ctypes.c_uint32)(engine.get_function_address("get"))


_KEPT: list[Any] = []
