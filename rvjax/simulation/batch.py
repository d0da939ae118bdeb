"""Many samples at once: the only module that knows of jit, vmap, devices and chunks.

A chunk is a fixed number of lanes, one sample each, flown on one device. One compiled program flies every chunk, several threads
fly chunks beside each other; what a chunk gives depends on its own numbers only. The compiled functions advance a chunk from one
step number to another, so a flight, its envelope and its replay run the very same code.

A CPU is one device to XLA, and its cores fly chunks of their own by a thread each: as fast as one XLA device a core, which would
compile everything once a core (docs/performance.md).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from functools import partial
from itertools import pairwise
from threading import Event, Lock
from typing import Any, NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray

from rvjax.components.metrics.interface import Metric
from rvjax.cores import cores
from rvjax.physics.state import Step
from rvjax.simulation import closed_loop, flight, jax_config
from rvjax.simulation.closed_loop import Drawn, Loop
from rvjax.simulation.flight import Carry, EnvelopePoint

LANES = 416
"""Samples of one chunk. A constant, because the last bits of a result may depend on it.

Whole vector registers, and arrays whose length is no power of two: those would all begin in the same few sets of the L1 cache.
More lanes fly up to 8 % faster, but the first chunk waits longer and cores idle at the end of a run; docs/performance.md.
"""


Device = Any
"""A device of JAX."""


class Flown(NamedTuple):
    """values: metric → (samples,). lost_s: time at which a flight stopped being finite, +∞ if never.

    glances: one per observed instant, of every sample. steps: one per observed instant, of the samples that were traced.
    """

    values: Mapping[str, NDArray[np.float64]]
    lost_s: NDArray[np.float64]
    glances: list[EnvelopePoint]
    steps: list[Step]


class Programs(NamedTuple):
    """The compiled functions of one device, for chunks of one number of lanes."""

    begin: Callable[[Any], tuple[Drawn, Carry]]
    advance: Callable[..., Any]
    glance: Callable[..., Any]
    finish: Callable[..., Any]


class Flyer:
    """Flies chunks of one structure and one number of lanes. Compiles once a device, whatever the numbers are; may be used by
    several threads at a time."""

    def __init__(self, loop: Loop, metrics: tuple[Metric, ...]) -> None:
        evaluate = jax.jit(partial(closed_loop.evaluate, loop))  # traced once for the four stages of a step

        begin = jax.vmap(partial(flight.begin, loop, metrics))

        def unpacked(structure: Any, rows: Any) -> tuple[Drawn, Carry]:
            numbers = jax.tree.unflatten(structure, list(rows))
            return numbers, begin(numbers)

        self._begin = jax.jit(unpacked, static_argnums=0)
        self._advance = compiled(partial(flight.advance, evaluate, metrics), 0, 0, None, None, donate=(1,))
        self._glance = compiled(partial(flight.glance, evaluate), 0, 0, None)
        self._finish = compiled(partial(flight.finish, evaluate, metrics), 0, 0, None)
        self._observe = compiled(partial(flight.observe, evaluate), 0, 0, None)
        self._programs: dict[Device, Programs] = {}
        self._compiling = Lock()
        self._stopped = Event()

    def fly(
        self,
        drawn: Drawn,
        steps: int,
        every: int,
        glance: bool = False,
        trace: Sequence[int] = (),
        device: Device | None = None,
    ) -> Flown:
        """Flies a chunk to its end.

        drawn: host numbers, each of shape (lanes,). every: steps between two observed instants, the last step always among them.
        glance: keep glances. trace: positions of the samples of which every observed step is kept. device: the first by default.
        Raises CancelledError after `stop`.
        """
        programs, numbers, carry = self._begun(drawn, device or devices()[0])
        glances: list[EnvelopePoint] = []
        kept: list[Step] = []
        chosen = np.asarray(trace, dtype=np.int64)

        def observe(k: int) -> None:
            if glance:
                glances.append(programs.glance(numbers, carry, k))
            if len(chosen):
                kept.append(jax.tree.map(lambda x: np.asarray(x, dtype=np.float64)[chosen], self._observe(numbers, carry, k)))

        for first in range(0, steps, every):
            if self._stopped.is_set():
                raise CancelledError
            observe(first)
            carry = programs.advance(numbers, carry, first, min(first + every, steps))
        observe(steps)
        values, lost = programs.finish(numbers, carry, steps)
        host = partial(np.asarray, dtype=np.float64)
        return Flown(jax.tree.map(host, values), host(lost), jax.tree.map(host, glances), kept)

    def watch(self, drawn: Drawn, instants: Sequence[int], look: Callable[[Drawn, Carry], bool]) -> None:
        """Flies a chunk for `look`, which gets the numbers as the compiled program has them, and the carry, at these steps; it
        says whether to go on."""
        programs, numbers, carry = self._begun(drawn, devices()[0])
        for first, last in pairwise((0, *instants)):
            carry = programs.advance(numbers, carry, first, last)
            if not look(*jax.tree.map(np.asarray, (numbers, carry))):
                break

    def _begun(self, drawn: Drawn, device: Device) -> tuple[Programs, Drawn, Carry]:
        """The programs of a device, and a chunk at t = 0."""
        leaves, structure = jax.tree.flatten(drawn)
        rows = jax.device_put(np.asarray(leaves, dtype=jax_config.precision()), device)  # one transfer, where 150 would take 6 ms
        programs = self._compiled(device, structure, rows)
        return programs, *programs.begin(rows)

    def stop(self) -> None:
        """Ends every flight of this flyer soon, in whatever thread it is."""
        self._stopped.set()

    def _compiled(self, device: Device, structure: Any, rows: Any) -> Programs:
        """The programs of a device; other threads wait, so that nothing is compiled twice. Compiling, which uses other threads
        than tracing, goes on beside the tracing of the next program."""
        with self._compiling:
            if device not in self._programs:
                begin = self._begin.lower(structure, rows)
                numbers, carry = jax.tree.map(
                    lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype, sharding=rows.sharding), begin.out_info
                )
                with ThreadPoolExecutor(len(Programs._fields)) as threads:
                    first = threads.submit(begin.compile)
                    advance = threads.submit(self._advance.lower(numbers, carry, 0, 0).compile)
                    glance = threads.submit(self._glance.lower(numbers, carry, 0).compile)
                    finish = threads.submit(self._finish.lower(numbers, carry, 0).compile)
                self._programs[device] = Programs(first.result(), advance.result(), glance.result(), finish.result())
            return self._programs[device]


class Tangents:
    """Flies chunks with the derivative of one metric along a change of the numbers, forward through the whole closed loop:

    m(n),  d/dε m(n + ε ṅ) at ε = 0
    """

    def __init__(self, loop: Loop, metric: Metric, name: str) -> None:
        """name: of the column of the metric that is differentiated."""
        evaluate = partial(closed_loop.evaluate, loop)

        def value(drawn: Drawn, steps: Any) -> Any:
            carry = flight.advance(evaluate, (metric,), drawn, flight.begin(loop, (metric,), drawn), 0, steps)
            return flight.finish(evaluate, (metric,), drawn, carry, steps)[0][name]

        def along(drawn: Drawn, tangent: Drawn, steps: Any) -> Any:
            return jax.jvp(lambda numbers: value(numbers, steps), (drawn,), (tangent,))

        self._along = compiled(along, 0, 0, None)

    def fly(self, drawn: Drawn, tangent: Drawn, steps: int) -> NDArray[np.float64]:
        """(n,) derivatives; host numbers, each of shape (n,), flown in chunks of LANES, the last one filled up."""
        precision, count = jax_config.precision(), len(jax.tree.leaves(drawn)[0])
        found: list[NDArray[np.float64]] = []
        for first in range(0, count, LANES):
            lanes = np.arange(first, first + LANES) % count
            rows = [jax.tree.map(lambda x, lanes=lanes: np.asarray(x, dtype=precision)[lanes], side) for side in (drawn, tangent)]
            found.append(np.asarray(self._along(*rows, steps)[1], dtype=np.float64)[: count - first])
        return np.concatenate(found)


def compiled(function: Callable[..., Any], *axes: int | None, donate: tuple[int, ...] = ()) -> Any:
    """A function of one sample as a compiled one of many. axes: 0 for an argument of which every sample has its own, None for one
    that all share. donate: arguments whose memory the results may take."""
    return jax.jit(jax.vmap(function, in_axes=axes), donate_argnums=donate)


def devices() -> list[Device]:
    """The devices that chunks fly on."""
    return jax.local_devices()


def streams() -> int:
    """How many chunks to fly beside each other: one a core, or two a device, so that the host's work hides behind flying."""
    return cores() if devices()[0].platform == "cpu" else 2 * len(devices())
