"""Many samples at once: the only module that knows of jit, vmap, devices and chunks.

A chunk is a fixed number of lanes, one sample each. One compiled program flies every chunk, several threads fly chunks beside
each other; what a chunk gives depends on its own numbers only. The compiled functions advance a chunk from one step number to
another, so a flight, its envelope and its replay run the very same code.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError
from functools import partial
from threading import Event, Lock
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from rvjax import closed_loop, flight
from rvjax.closed_loop import Drawn, Loop
from rvjax.flight import Carry, Glance
from rvjax.metrics.interface import Metric
from rvjax.state import Step

LANES = 256
"""Samples of one chunk. A constant, because the last bits of a result may depend on it."""


class Flown(NamedTuple):
    """values: metric → (samples,). lost_s: time at which a flight stopped being finite, +∞ if never.

    glances: one per observed instant, of every sample. steps: one per observed instant, of the samples that were traced.
    """

    values: Mapping[str, NDArray[np.float64]]
    lost_s: NDArray[np.float64]
    glances: list[Glance]
    steps: list[Step]


class Flyer:
    """Flies chunks of one structure. Compiles once, whatever the numbers are; may be used by several threads at a time."""

    def __init__(self, loop: Loop, metrics: tuple[Metric, ...]) -> None:
        evaluate = jax.jit(partial(closed_loop.evaluate, loop))  # traced once for the four stages of a step
        observe = jax.vmap(partial(flight.observe, evaluate), in_axes=(0, 0, None))

        def compiled(function: Callable[..., Any], *axes: int | None, donate: tuple[int, ...] = ()) -> Callable[..., Any]:
            return jax.jit(jax.vmap(function, in_axes=axes), donate_argnums=donate)

        def trace(numbers: Drawn, carry: Carry, k: int, chosen: NDArray[np.int64]) -> Step:
            return jax.tree.map(lambda x: x[chosen], observe(numbers, carry, k))

        self._begin = compiled(partial(flight.begin, loop, metrics), 0)
        self._advance = compiled(partial(flight.advance, evaluate, metrics), 0, 0, None, None, donate=(1,))
        self._glance = compiled(partial(flight.glance, evaluate), 0, 0, None)
        self._trace = jax.jit(trace)
        self._finish = compiled(partial(flight.finish, evaluate, metrics), 0, 0, None)
        self._first = Lock()
        self._warm = False
        self._stopped = Event()

    def fly(self, drawn: Drawn, steps: int, every: int, glance: bool = False, trace: Sequence[int] = ()) -> Flown:
        """Flies a chunk to its end.

        drawn: host numbers, each of shape (LANES,). every: steps between two observed instants, the last step always among them.
        glance: keep glances. trace: positions of the samples of which every observed step is kept.
        Raises CancelledError after `stop`.
        """
        numbers = jax.tree.map(jnp.asarray, drawn)
        self._compile(numbers)
        carry = self._begin(numbers)
        glances: list[Glance] = []
        kept: list[Step] = []
        chosen = np.asarray(trace, dtype=np.int64)

        def observe(k: int) -> None:
            if glance:
                glances.append(self._glance(numbers, carry, k))
            if len(chosen):
                kept.append(self._trace(numbers, carry, k, chosen))

        for first in range(0, steps, every):
            if self._stopped.is_set():
                raise CancelledError
            observe(first)
            carry = self._advance(numbers, carry, first, min(first + every, steps))
        observe(steps)
        values, lost = self._finish(numbers, carry, steps)
        host = partial(np.asarray, dtype=np.float64)
        return Flown(*(jax.tree.map(host, part) for part in (values, lost, glances, kept)))

    def stop(self) -> None:
        """Ends every flight of this flyer soon, in whatever thread it is."""
        self._stopped.set()

    def _compile(self, numbers: Drawn) -> None:
        """Compiles by a flight of no steps; other threads wait, so that nothing is compiled twice."""
        with self._first:
            if not self._warm:
                carry = self._advance(numbers, self._begin(numbers), 0, 0)
                self._glance(numbers, carry, 0)
                self._finish(numbers, carry, 0)
                self._warm = True
