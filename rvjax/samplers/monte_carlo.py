"""Monte Carlo: u = the stream of the variable at the sample, independent of every other variable and sample."""

from __future__ import annotations

from dataclasses import dataclass

from rvjax.samplers.interface import Samples, Values
from rvjax.streams import uniforms


@dataclass(frozen=True)
class MonteCarlo:
    """Streams with names; see `rvjax.streams`."""

    seed: int

    def at(self, samples: Samples) -> Streams:
        """The points of some samples."""
        return Streams(self.seed, samples)


@dataclass(frozen=True)
class Streams:
    """The streams of some samples."""

    seed: int
    samples: Samples

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1)."""
        return uniforms(self.seed, name, self.samples)[:, :count]
