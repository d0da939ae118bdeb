"""Many samples at once: the only module that knows of jit, vmap, devices and chunks.

A chunk is a fixed number of lanes on a single device; each lane flies a sample. The same compiled program flies every chunk, and
several threads fly chunks in parallel. The result of a chunk depends on its numbers only. The compiled functions advance a chunk
between two step numbers, so a flight, its envelope and its replay run the same code.

To XLA a CPU is a single device. A thread per core flies chunks on it: as fast as an XLA device per core, which would compile
everything once per core (docs/performance.md).
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from functools import partial
from itertools import pairwise
from threading import Event, Lock
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray

from rvjax.components.metrics.interface import Metric
from rvjax.cores import cores
from rvjax.physics.state import Step
from rvjax.simulation import closed_loop, flight, jax_config
from rvjax.simulation.closed_loop import Drawn, Loop
from rvjax.simulation.flight import Carry, EnvelopePoint

if TYPE_CHECKING:
    from rvjax.simulation.problem import Problem

LANES = 416
"""Samples of a chunk. A constant, because the last bits of a result may depend on it.

It fills whole vector registers. It is no power of two: such arrays would all begin in the same few sets of the L1 cache. More
lanes fly up to 8 % faster, but the first chunk takes longer and cores idle at the end of a run; docs/performance.md.
"""

Device = Any
"""A device of JAX."""


class Flown(NamedTuple):
    """values: metric → (samples,). lost_s: time at which a flight stopped being finite, +∞ if never.

    envelope: a point per observed instant, of every sample. steps: a Step per observed instant, of the traced samples.
    """

    values: Mapping[str, NDArray[np.float64]]
    lost_s: NDArray[np.float64]
    envelope: list[EnvelopePoint]
    steps: list[Step]


class Programs(NamedTuple):
    """The compiled functions of a flight, for a device, a number of lanes and a precision."""

    begin: Callable[[Any], tuple[Drawn, Carry]]
    advance: Callable[..., Any]
    envelope_point: Callable[..., Any]
    finish: Callable[..., Any]


class Compiler:
    """The functions of a flight, compiled once per device, number of lanes and precision. Several threads may share it."""

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
        self._programs: dict[tuple[Any, ...], Programs] = {}
        self._compiling = Lock()

    def programs(self, device: Device, structure: Any, rows: Any) -> Programs:
        """The programs of a device for these numbers. Other threads wait, so nothing is compiled twice. A program compiles in the
        background while the next is traced."""
        key = (device, structure, rows.shape, rows.dtype)
        with self._compiling:
            if key not in self._programs:
                begin = self._begin.lower(structure, rows)
                numbers, carry = jax.tree.map(
                    lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype, sharding=rows.sharding), begin.out_info
                )
                with ThreadPoolExecutor(len(Programs._fields)) as threads:
                    first = threads.submit(begin.compile)
                    advance = threads.submit(self._advance.lower(numbers, carry, 0, 0).compile)
                    point = threads.submit(self._envelope_point.lower(numbers, carry, 0).compile)
                    finish = threads.submit(self._finish.lower(numbers, carry, 0).compile)
                self._programs[key] = Programs(first.result(), advance.result(), point.result(), finish.result())
            return self._programs[key]


KEPT = 8
"""Compilers that a process keeps: those used last."""

_compilers: OrderedDict[str, Compiler] = OrderedDict()
_choosing = Lock()


def compiler_of(problem: Problem) -> Compiler:
    """The compiler of a problem. Problems of the same structure share it, so a process that flies a campaign again with other
    numbers does not trace and compile again."""
    with _choosing:
        if problem.structure not in _compilers:
            _compilers[problem.structure] = Compiler(problem.loop, problem.metrics)
        _compilers.move_to_end(problem.structure)
        while len(_compilers) > KEPT:
            _compilers.popitem(last=False)
        return _compilers[problem.structure]


class Flyer:
    """Flies chunks of the same structure. Several threads may use it at a time."""

    def __init__(self, compiler: Compiler) -> None:
        self._compiler = compiler
        self._stopped = Event()
        self._steps, self._counting = 0, Lock()

    @classmethod
    def of(cls, problem: Problem) -> Flyer:
        """The flyer of a problem, with the compiler of its structure."""
        return cls(compiler_of(problem))

    def fly(
        self,
        drawn: Drawn,
        steps: int,
        every: int,
        *,
        with_envelope: bool = False,
        trace: Sequence[int] = (),
        device: Device | None = None,
    ) -> Flown:
        """Flies a chunk to its end.

        drawn: host numbers, each of shape (lanes,). every: steps between two observed instants; the last step is always observed.
        with_envelope: keep the points of the envelopes. trace: positions of the samples whose observed steps are kept. device:
        the first by default. Raises CancelledError after `stop`.
        """
        programs, numbers, carry = self._begun(drawn, device or devices()[0])
        envelope: list[EnvelopePoint] = []
        kept: list[Step] = []
        observed = self._compiler.observe
        chosen = np.asarray(trace, dtype=np.int64)

        def observe(k: int) -> None:
            if with_envelope:
                envelope.append(programs.envelope_point(numbers, carry, k))
            if len(chosen):
                kept.append(jax.tree.map(lambda x: np.asarray(x, dtype=np.float64)[chosen], observed(numbers, carry, k)))

        for first in range(0, steps, every):
            if self._stopped.is_set():
                raise CancelledError
            observe(first)
            last = min(first + every, steps)
            carry = jax.block_until_ready(programs.advance(numbers, carry, first, last))
            with self._counting:
                self._steps += last - first
        observe(steps)
        values, lost = programs.finish(numbers, carry, steps)
        host = partial(np.asarray, dtype=np.float64)
        return Flown(jax.tree.map(host, values), host(lost), jax.tree.map(host, envelope), kept)

    @property
    def steps_flown(self) -> int:
        """Steps that its chunks have flown so far, in all threads: how far the flights under way are."""
        return self._steps

    def watch(self, drawn: Drawn, instants: Sequence[int], look: Callable[[Drawn, Carry], bool]) -> None:
        """Flies a chunk and calls look(numbers, carry) at these steps, with the numbers of the compiled program. It ends where
        `look` returns False."""
        programs, numbers, carry = self._begun(drawn, devices()[0])
        for first, last in pairwise((0, *instants)):
            carry = programs.advance(numbers, carry, first, last)
            if not look(*jax.tree.map(np.asarray, (numbers, carry))):
                break

    def _begun(self, drawn: Drawn, device: Device) -> tuple[Programs, Drawn, Carry]:
        """The programs of a device, and a chunk at t = 0."""
        leaves, structure = jax.tree.flatten(drawn)
        rows = jax.device_put(np.asarray(leaves, dtype=jax_config.precision()), device)  # a single transfer; 150 would take 6 ms
        programs = self._compiler.programs(device, structure, rows)
        return programs, *programs.begin(rows)

    def stop(self) -> None:
        """Ends all flights of this flyer soon, in all threads."""
        self._stopped.set()


class Tangents:
    """Flies chunks with the derivative of a metric along a change of the numbers, in forward mode through the closed loop:

    m(n),  d/dε m(n + ε ṅ) at ε = 0
    """

    def __init__(self, loop: Loop, metric: Metric, name: str) -> None:
        """name: column of the metric that is differentiated."""
        evaluate = partial(closed_loop.evaluate, loop)

        def value(drawn: Drawn, steps: Any) -> Any:
            carry = flight.advance(evaluate, (metric,), drawn, flight.begin(loop, (metric,), drawn), 0, steps)
            return flight.finish(evaluate, (metric,), drawn, carry, steps)[0][name]

        def along(drawn: Drawn, tangent: Drawn, steps: Any) -> Any:
            return jax.jvp(lambda numbers: value(numbers, steps), (drawn,), (tangent,))

        self._along = compiled(along, 0, 0, None)

    def fly(self, drawn: Drawn, tangent: Drawn, steps: int) -> NDArray[np.float64]:
        """(n,) derivatives. drawn, tangent: host numbers, each of shape (n,). Flown in chunks of LANES; the last is padded."""
        precision, count = jax_config.precision(), len(jax.tree.leaves(drawn)[0])
        slopes: list[NDArray[np.float64]] = []
        for first in range(0, count, LANES):
            lanes = np.arange(first, first + LANES) % count
            rows = [jax.tree.map(lambda x, lanes=lanes: np.asarray(x, dtype=precision)[lanes], side) for side in (drawn, tangent)]
            slopes.append(np.asarray(self._along(*rows, steps)[1], dtype=np.float64)[: count - first])
        return np.concatenate(slopes)


def compiled(function: Callable[..., Any], *axes: int | None, donate: tuple[int, ...] = ()) -> Any:
    """The compiled function of many samples, from a function of a single sample.

    axes: per argument, 0 if it has an entry per sample, None if all samples share it. donate: arguments whose memory the results
    may reuse.
    """
    return jax.jit(jax.vmap(function, in_axes=axes), donate_argnums=donate)


def devices() -> list[Device]:
    """The devices that chunks fly on."""
    return jax.local_devices()


def streams() -> int:
    """How many chunks to fly in parallel: a thread per core of a CPU, else two per device so that the host works meanwhile."""
    return cores() if devices()[0].platform == "cpu" else 2 * len(devices())
