"""Chunks in flight with machine code of LLVM."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache, partial
from threading import Lock, RLock, Thread
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from rvjax.components.metrics.interface import Metric
from rvjax.cores import cores
from rvjax.physics.state import Step
from rvjax.physics.vectors import Channels
from rvjax.simulation import closed_loop, flight, jax_config, mean_wrench
from rvjax.simulation.closed_loop import Drawn, Loop
from rvjax.simulation.engines.interface import Device
from rvjax.simulation.engines.llvm.from_jaxpr import scalarised
from rvjax.simulation.engines.llvm.machine_code import Function, Target, blocks, host, packed, unpacked
from rvjax.simulation.engines.llvm.program import Program
from rvjax.simulation.engines.llvm.text import Kernel
from rvjax.simulation.flight import Carry, EnvelopePoint
from rvjax.simulation.mean_wrench import Summed
from rvjax.timings import phase

EMITTER = 1
"""Version of the way from a jaxpr to machine code: another number where a flight gets other bits."""

FLIGHT = ("begin", "advance", "finish")
"""The functions that every flight needs."""

ADVANCING = ("begin", "advance", "mean_wrench")
"""The functions whose results the next step takes."""

PAYS = 1_500_000
"""Steps of single samples from which on optimising pays: code that is compiled as fast as possible takes a second more for two
million steps, and optimising takes a second."""

WORTH_A_THREAD = 500
"""Steps of a group, about a millisecond, below which handing work to a thread takes longer than it gains."""

Rows = NDArray[Any]


class Traced(NamedTuple):
    """A function of a flight as a scalar program, the tree of its results as shapes, and how many numbers that is."""

    program: Program
    results: Any
    size: int


class Flight:
    """The functions of a flight for a structure of the numbers and a precision: traced, scalarised and compiled when they are
    first needed."""

    def __init__(self, loop: Loop, metrics: tuple[Metric, ...], numbers: Drawn, target: Target) -> None:
        """numbers: as shapes of a single sample."""
        evaluate = jax.jit(partial(closed_loop.evaluate, loop))  # traced once for the four stages of a step
        self.numbers, self.real = numbers, np.dtype(jax.tree.leaves(numbers)[0].dtype)
        self.target, self.lanes = target, target.lanes * 8 // self.real.itemsize
        self._functions: Mapping[str, Callable[..., Any]] = {
            "begin": partial(flight.begin, loop, metrics),
            "advance": partial(flight.step, evaluate, metrics),
            "envelope_point": partial(flight.envelope_point, evaluate),
            "observe": partial(flight.observe, evaluate),
            "mean_wrench": partial(mean_wrench.step, evaluate),
            "finish": partial(flight.finish, evaluate, metrics),
        }
        self._k = jax.ShapeDtypeStruct((), jnp.int32)
        self._traced: dict[str, Traced] = {}
        self._compiled: dict[tuple[str, int], Function] = {}
        self._announced = self._begun = 0
        self._tracing, self._compiling = RLock(), RLock()

    @property
    def carry(self) -> Carry:
        """The carry, as shapes of a single sample."""
        return self.traced("begin").results

    def _taken(self, name: str) -> Any:
        """What a function gets from the step before, as shapes of a single sample."""
        return () if name == "begin" else Summed(self.carry, self.numbers.upper) if name == "mean_wrench" else self.carry

    def traced(self, name: str) -> Traced:
        """A function as a scalar program. Errors: UnsupportedError."""
        with self._tracing:
            if name not in self._traced:
                stepped = name != "begin"
                given = (self.numbers, self._taken(name), self._k) if stepped else (self.numbers,)
                with phase("trace"):
                    program, results = scalarised(self._functions[name], *given, step=stepped)
                    self._traced[name] = Traced(program, results, count(results))
            return self._traced[name]

    def count_begun(self, steps: int) -> None:
        """Counts the steps of single samples of a chunk that begins."""
        with self._compiling:
            self._begun += steps

    def prepare(self, steps: int) -> None:
        """Compiles the step in a thread. steps: of single samples, to come. An error comes again where the step is needed."""

        def compile_step() -> None:
            with suppress(Exception):
                self.function("advance")

        self.traced("advance")
        self._announced = max(self._announced, steps)
        Thread(target=compile_step).start()  # no daemon: LLVM must not be at work when the process ends

    def function(self, name: str) -> Function:
        """The machine code of a function: optimised for the steps of flights that last, else compiled as fast as possible."""
        with self._compiling:
            level = 2 if name == "advance" and max(self._announced, self._begun) >= PAYS else 0
            if (name, level) not in self._compiled:
                kernel = Kernel(
                    self.traced(name).program,
                    numbers=count(self.numbers),
                    carry=count(self._taken(name)),
                    lanes=self.lanes,
                    real=self.real,
                    out=self.real if name in ADVANCING else np.dtype(np.float64),
                )
                with phase("compile"):
                    self._compiled[name, level] = Function(kernel, self.target, level)
            return self._compiled[name, level]

    def digest(self) -> str:
        """SHA-256 of what its flights compute."""
        programs = "".join(self.traced(name).program.digest() for name in FLIGHT)
        return hashlib.sha256(f"{EMITTER} {programs}".encode()).hexdigest()[:16]


class LlvmEngine:
    """The functions of a flight as machine code, compiled once per structure of the numbers and precision."""

    name = "llvm"
    fixed_lanes = False

    def __init__(self, loop: Loop, metrics: tuple[Metric, ...], target: Target | None = None) -> None:
        """target: the processor; this one by default. It changes no bit."""
        self._loop, self._metrics, self._target = loop, metrics, target
        self._flights: dict[Any, Flight] = {}
        self._making = Lock()

    def flight(self, drawn: Drawn) -> Flight:
        """The flight for numbers of this structure, in the precision of the process."""
        structure, real = jax.tree.structure(drawn), np.dtype(jax_config.precision())
        with self._making:
            if (structure, real) not in self._flights:
                shapes = jax.tree.map(lambda x: jax.ShapeDtypeStruct((), real), drawn)
                self._flights[structure, real] = Flight(self._loop, self._metrics, shapes, self._target or host())
            return self._flights[structure, real]

    def identity(self, drawn: Drawn) -> Mapping[str, Any]:
        """The precision and the digest of the program: nothing of the machine."""
        return {"engine": self.name, "precision": jax_config.precision(), "program": self.flight(drawn).digest()}

    def prepare(self, drawn: Drawn, steps: int) -> None:
        """Begins to compile the step in a thread."""
        self.flight(drawn).prepare(steps)

    def begin(self, drawn: Drawn, device: Device | None = None, steps: int = 0) -> LlvmChunk:
        """A chunk at t = 0, on this processor."""
        del device
        functions = self.flight(drawn)
        chunk = LlvmChunk(functions, drawn)
        functions.count_begun(chunk.samples * steps)
        return chunk


@cache
def _pool() -> ThreadPoolExecutor:
    """Threads for parts of chunks."""
    return ThreadPoolExecutor(cores())


class LlvmChunk:
    """A chunk in memory: groups of lanes, each with its numbers and its carry side by side. samples: how many fly."""

    def __init__(self, functions: Flight, drawn: Drawn) -> None:
        self._flight, real = functions, functions.real
        rows = np.asarray(jax.tree.leaves(drawn), dtype=real)
        self.samples, self._numbers = rows.shape[1], packed(rows, functions.lanes)
        self._groups = len(self._numbers)
        self._carry = self._memory(count(functions.carry), real)
        functions.function("begin")(self._groups, 0, 1, self._numbers, self._carry, self._carry)

    def _memory(self, leaves: int, kind: Any) -> Rows:
        return blocks(self._groups, leaves, self._flight.lanes, kind)

    def advance(self, first: int, last: int, threads: int = 1) -> None:
        """Flies from step `first` to step `last`, on several threads. Which thread flies a group changes no bit."""
        if first >= last:
            return
        advance = self._flight.function("advance")
        parts = max(1, min(threads, self._groups, self._groups * (last - first) // WORTH_A_THREAD))
        edges = [self._groups * part // parts for part in range(parts + 1)]

        def fly(part: int) -> None:
            groups = slice(edges[part], edges[part + 1])
            carry = self._carry[groups]
            advance(len(carry), first, last, self._numbers[groups], carry, carry)

        if parts == 1:
            fly(0)
        else:
            list(_pool().map(fly, range(parts)))

    def envelope_point(self, k: int) -> EnvelopePoint:
        """The point of the envelopes at step k."""
        return self._looked("envelope_point", k)

    def observe(self, k: int) -> Step:
        """All values at step k."""
        return self._looked("observe", k)

    def mean_wrench(self, first: int, last: int) -> Channels:
        """The mean total wrench from step `first` to step `last`."""
        traced, carry = self._flight.traced("mean_wrench"), self._carry.shape[1]
        summed = self._memory(traced.size, self._flight.real)
        summed[:, :carry] = self._carry
        self._flight.function("mean_wrench")(self._groups, first, last, self._numbers, summed, summed)
        return self._tree(summed[:, carry:] / (last - first), traced.results.means)

    def finish(self, k: int) -> tuple[Mapping[str, Any], Any]:
        """The metrics, and the times of loss."""
        return self._looked("finish", k)

    def numbers_and_carry(self) -> tuple[Drawn, Carry]:
        """The numbers that fly, and what passes to the next step."""
        return self._tree(self._numbers, self._flight.numbers), self._tree(self._carry, self._flight.carry)

    def _looked(self, name: str, k: int) -> Any:
        traced = self._flight.traced(name)
        out = self._memory(traced.size, np.float64)
        self._flight.function(name)(self._groups, k, k + 1, self._numbers, self._carry, out)
        return self._tree(out, traced.results)

    def _tree(self, memory: Rows, shapes: Any) -> Any:
        """The arrays over the lanes; a NaN has its usual bits."""
        rows = unpacked(memory, self.samples)
        rows[np.isnan(rows)] = np.nan
        leaves, structure = jax.tree.flatten(shapes)
        arrays: list[Rows] = []
        first = 0
        for leaf in leaves:
            size = math.prod(leaf.shape)
            part = rows[first : first + size]
            arrays.append(part[0] if leaf.shape == () else np.moveaxis(part.reshape(*leaf.shape, -1), -1, 0))
            first += size
        return jax.tree.unflatten(structure, arrays)


def count(tree: Any) -> int:
    """The numbers of a tree of shapes."""
    return sum(math.prod(leaf.shape) for leaf in jax.tree.leaves(tree))
