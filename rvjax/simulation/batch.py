"""Many samples at once: chunks of lanes, flown by an engine.

A chunk is a fixed number of lanes on a single device; each lane flies a sample. The same compiled program flies every chunk, and
several threads fly chunks in parallel. The result of a chunk depends on its numbers only. The compiled functions advance a chunk
between two step numbers, so a flight, its envelope and its replay run the same code.

To XLA a CPU is a single device. A thread per core flies chunks on it: as fast as an XLA device per core, which would compile
everything once per core (docs/performance.md).
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
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
from rvjax.physics.vectors import Channels
from rvjax.simulation import closed_loop, flight, jax_config
from rvjax.simulation.closed_loop import Drawn, Loop
from rvjax.simulation.engines.choice import engine_of
from rvjax.simulation.engines.interface import Device, Engine
from rvjax.simulation.engines.xla import compiled
from rvjax.simulation.flight import Carry, EnvelopePoint

if TYPE_CHECKING:
    from rvjax.simulation.problem import Problem

LANES = 416
"""Samples of a chunk. A constant, because the last bits of a result may depend on it.

It fills whole vector registers. It is no power of two: such arrays would all begin in the same few sets of the L1 cache. More
lanes fly up to 8 % faster, but the first chunk takes longer and cores idle at the end of a run; docs/performance.md.
"""


class Flown(NamedTuple):
    """values: metric → (samples,). lost_s: time at which a flight stopped being finite, +∞ if never.

    envelope: a point per observed instant, of every sample. steps: a Step per observed instant, of the traced samples. means: of
    these the mean total wrench from each instant to the next.
    """

    values: Mapping[str, NDArray[np.float64]]
    lost_s: NDArray[np.float64]
    envelope: list[EnvelopePoint]
    steps: list[Step]
    means: list[Channels]


class Flyer:
    """Flies chunks of the same structure. Several threads may use it at a time."""

    def __init__(self, engine: Engine, threads: int | None = None) -> None:
        """threads: that fly at a time; all cores by default."""
        self.engine = engine
        self._available = threads or cores()
        self._stopped = Event()
        self._steps, self._flying, self._counting = 0, 0, Lock()

    @classmethod
    def of(cls, problem: Problem, threads: int | None = None) -> Flyer:
        """The flyer of a problem, with the engine of its structure."""
        return cls(engine_of(problem), threads)

    def lanes(self, samples: int) -> int:
        """How many lanes fly for up to LANES samples: LANES with an engine of fixed lanes, else no more than needed."""
        return LANES if self.engine.fixed_lanes else samples

    @property
    def divides_chunks(self) -> bool:
        """Whether a chunk alone flies on all threads."""
        return not self.engine.fixed_lanes

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
        envelope: list[EnvelopePoint] = []
        kept: list[Step] = []
        means: list[Channels] = []
        chosen = np.asarray(trace, dtype=np.int64)
        whole = not self.engine.fixed_lanes and chosen.tolist() == list(range(len(jax.tree.leaves(drawn)[0])))

        def traced(values: Any) -> Any:
            return values if whole else jax.tree.map(lambda x: np.asarray(x, dtype=np.float64)[chosen], values)

        def observe(k: int) -> None:
            if with_envelope:
                envelope.append(flying.envelope_point(k))
            if len(chosen):
                kept.append(traced(flying.observe(k)))

        with self._counted():
            flying = self.engine.begin(drawn, device, steps)
            for first in range(0, steps, every):
                if self._stopped.is_set():
                    raise CancelledError
                observe(first)
                last = min(first + every, steps)
                if len(chosen):
                    means.append(traced(flying.mean_wrench(first, last)))
                flying.advance(first, last, self._threads())
                with self._counting:
                    self._steps += last - first
            observe(steps)
            values, lost = flying.finish(steps)
        host = partial(np.asarray, dtype=np.float64)
        return Flown(jax.tree.map(host, values), host(lost), jax.tree.map(host, envelope), kept, means)

    @property
    def steps_flown(self) -> int:
        """Steps that its chunks have flown so far, in all threads: how far the flights under way are."""
        return self._steps

    def watch(self, drawn: Drawn, instants: Sequence[int], look: Callable[[Drawn, Carry], bool]) -> None:
        """Flies a chunk and calls look(numbers, carry) at these steps, with the numbers of the compiled program. It ends where
        `look` returns False."""
        with self._counted():
            flying = self.engine.begin(drawn, steps=max(instants, default=0))
            for first, last in pairwise((0, *instants)):
                flying.advance(first, last, self._threads())
                if not look(*flying.numbers_and_carry()):
                    break

    @contextmanager
    def _counted(self) -> Generator[None, None, None]:
        """A chunk is in flight."""
        with self._counting:
            self._flying += 1
        try:
            yield
        finally:
            with self._counting:
                self._flying -= 1

    def _threads(self) -> int:
        """Threads for a chunk: several, where fewer chunks than threads are in flight, as at the end of a run."""
        return max(1, self._available // max(1, self._flying))

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


def devices() -> list[Device]:
    """The devices that chunks fly on."""
    return jax.local_devices()


def streams() -> int:
    """How many chunks to fly in parallel: a thread per core of a CPU, else two per device so that the host works meanwhile."""
    return cores() if devices()[0].platform == "cpu" else 2 * len(devices())
