"""Interface of an engine."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from rvjax.physics.state import Step
from rvjax.physics.vectors import Channels
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.flight import Carry, EnvelopePoint

Device = Any
"""A device of JAX."""


class Chunk(Protocol):
    """A chunk of samples in flight, a sample per lane. Every number that it gives is an array over the lanes."""

    def advance(self, first: int, last: int, threads: int = 1) -> None:
        """Flies from step `first` to step `last` and then returns. threads: the largest number of threads to use."""
        ...

    def envelope_point(self, k: int) -> EnvelopePoint:
        """The point of the envelopes at step k."""
        ...

    def observe(self, k: int) -> Step:
        """All values at step k."""
        ...

    def mean_wrench(self, first: int, last: int) -> Channels:
        """The mean total wrench from step `first`, at which the chunk is, to step `last` (`simulation.mean_wrench`).

        It flies these steps on a copy: the chunk stays where it is.
        """
        ...

    def finish(self, k: int) -> tuple[Mapping[str, Any], Any]:
        """The metrics after the last step k, and the time at which each flight was lost (+∞: never)."""
        ...

    def numbers_and_carry(self) -> tuple[Drawn, Carry]:
        """The numbers that fly, and what passes to the next step."""
        ...


class Engine(Protocol):
    """Compiles a flight once per number of lanes, device and precision. Several threads may share it."""

    @property
    def name(self) -> str:
        """As in a campaign."""
        ...

    @property
    def fixed_lanes(self) -> bool:
        """Whether it compiles for a number of lanes, on which bits may depend. All chunks then have the same."""
        ...

    def identity(self, drawn: Drawn) -> Mapping[str, Any]:
        """What the bits of its flights depend on, besides numbers and code. drawn: numbers of some samples."""
        ...

    def prepare(self, drawn: Drawn, steps: int) -> None:
        """Begins to compile what takes longest, in the background, where that is possible. steps: of single samples, to come."""
        ...

    def begin(self, drawn: Drawn, device: Device | None = None, steps: int = 0) -> Chunk:
        """A chunk at t = 0. drawn: host numbers, each of shape (lanes,). steps: how many it will fly, as far as that is known."""
        ...
