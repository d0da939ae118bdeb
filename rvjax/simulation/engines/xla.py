"""The engine `xla`: JAX's compiler, on its devices."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from threading import Lock
from typing import Any, NamedTuple

import jax
import numpy as np

from rvjax.components.metrics.interface import Metric
from rvjax.physics.state import Step
from rvjax.physics.vectors import Channels
from rvjax.simulation import closed_loop, flight, jax_config
from rvjax.simulation.closed_loop import Drawn, Loop
from rvjax.simulation.engines.interface import Device
from rvjax.simulation.flight import Carry, EnvelopePoint
from rvjax.simulation.mean_wrench import mean_wrench
from rvjax.timings import phase


class Programs(NamedTuple):
    """The compiled functions of a flight, for a device, a number of lanes and a precision."""

    begin: Callable[[Any], tuple[Drawn, Carry]]
    advance: Callable[..., Any]
    envelope_point: Callable[..., Any]
    finish: Callable[..., Any]


class XlaEngine:
    """The functions of a flight, compiled once per device, number of lanes and precision."""

    name = "xla"
    fixed_lanes = True

    def __init__(self, loop: Loop, metrics: tuple[Metric, ...]) -> None:
        evaluate = jax.jit(partial(closed_loop.evaluate, loop))  # traced once for the four stages of a step

        begin = jax.vmap(partial(flight.begin, loop, metrics))

        def unpacked(structure: Any, rows: Any) -> tuple[Drawn, Carry]:
            numbers = jax.tree.unflatten(structure, list(rows))
            return numbers, begin(numbers)

        self._begin = jax.jit(unpacked, static_argnums=0)
        self._advance = compiled(partial(flight.advance, evaluate, metrics), 0, 0, None, None, donate=(1,))
        self._envelope_point = compiled(partial(flight.envelope_point, evaluate), 0, 0, None)
        self._finish = compiled(partial(flight.finish, evaluate, metrics), 0, 0, None)
        self.observe = compiled(partial(flight.observe, evaluate), 0, 0, None)
        self.mean_wrench = compiled(partial(mean_wrench, evaluate), 0, 0, None, None)
        self._programs: dict[tuple[Any, ...], Programs] = {}
        self._compiling = Lock()

    def identity(self, drawn: Drawn) -> Mapping[str, Any]:
        """The settings of the compiler, and the processor: XLA's code depends on all of them."""
        del drawn
        return {"engine": self.name, **jax_config.settings()}

    def prepare(self, drawn: Drawn, steps: int) -> None:
        """Nothing: it compiles for a number of lanes and a device, in the background while it traces."""
        del drawn, steps

    def begin(self, drawn: Drawn, device: Device | None = None, steps: int = 0) -> XlaChunk:
        """A chunk at t = 0, on a device; the first by default."""
        del steps
        leaves, structure = jax.tree.flatten(drawn)
        place = device or jax.local_devices()[0]
        rows = jax.device_put(np.asarray(leaves, dtype=jax_config.precision()), place)  # a single transfer; 150 would take 6 ms
        programs = self._compiled(place, structure, rows)
        return XlaChunk(programs, self, *programs.begin(rows))

    def _compiled(self, device: Device, structure: Any, rows: Any) -> Programs:
        """The programs of a device for these numbers. Other threads wait, so nothing is compiled twice. A program compiles in the
        background while the next is traced."""
        key = (device, structure, rows.shape, rows.dtype)
        with self._compiling:
            if key not in self._programs:
                self._programs[key] = self._compile(structure, rows)
            return self._programs[key]

    def _compile(self, structure: Any, rows: Any) -> Programs:
        with phase("compile"):
            begin = self._begin.lower(structure, rows)
            numbers, carry = jax.tree.map(
                lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype, sharding=rows.sharding), begin.out_info
            )
            with ThreadPoolExecutor(len(Programs._fields)) as threads:
                first = threads.submit(begin.compile)
                advance = threads.submit(self._advance.lower(numbers, carry, 0, 0).compile)
                point = threads.submit(self._envelope_point.lower(numbers, carry, 0).compile)
                finish = threads.submit(self._finish.lower(numbers, carry, 0).compile)
            return Programs(first.result(), advance.result(), point.result(), finish.result())


class XlaChunk:
    """A chunk on a device of JAX."""

    def __init__(self, programs: Programs, engine: XlaEngine, numbers: Drawn, carry: Carry) -> None:
        self._programs, self._engine = programs, engine
        self._numbers, self._carry = numbers, carry

    def advance(self, first: int, last: int, threads: int = 1) -> None:
        """Flies from step `first` to step `last`. XLA decides on threads."""
        del threads
        self._carry = jax.block_until_ready(self._programs.advance(self._numbers, self._carry, first, last))

    def envelope_point(self, k: int) -> EnvelopePoint:
        """The point of the envelopes at step k."""
        return self._programs.envelope_point(self._numbers, self._carry, k)

    def observe(self, k: int) -> Step:
        """All values at step k."""
        return self._engine.observe(self._numbers, self._carry, k)

    def mean_wrench(self, first: int, last: int) -> Channels:
        """The mean total wrench from step `first` to step `last`."""
        return self._engine.mean_wrench(self._numbers, self._carry, first, last)

    def finish(self, k: int) -> tuple[Mapping[str, Any], Any]:
        """The metrics, and the times of loss."""
        return self._programs.finish(self._numbers, self._carry, k)

    def numbers_and_carry(self) -> tuple[Drawn, Carry]:
        """The numbers that fly, and what passes to the next step."""
        return jax.tree.map(np.asarray, (self._numbers, self._carry))


def compiled(function: Callable[..., Any], *axes: int | None, donate: tuple[int, ...] = ()) -> Any:
    """The compiled function of many samples, from a function of a single sample.

    axes: per argument, 0 if it has an entry per sample, None if all samples share it. donate: arguments whose memory the results
    may reuse.
    """
    return jax.jit(jax.vmap(function, in_axes=axes), donate_argnums=donate)
