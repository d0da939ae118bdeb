"""Monte Carlo: u = the stream of the variable at the sample, independent of every other variable and sample.

The default. Samples are independent draws of the campaign's law, so bounds and verdicts hold; see `rvjax.stats.random_streams`.
"""

from __future__ import annotations

from dataclasses import dataclass

from rvjax.campaign import Model
from rvjax.components.samplers.interface import Samples, Sampling, Scheme, Streams
from rvjax.stats.sampling_design import Independent


class Parameters(Model):
    """There are none."""


@dataclass(frozen=True)
class MonteCarlo:
    """Streams with names."""

    seed: int

    def at(self, samples: Samples) -> Streams:
        """The points of some samples."""
        return Streams(self.seed, samples, {})


COMPONENT = Sampling(Parameters, lambda parameters: Scheme(lambda setting: MonteCarlo(setting.seed)), basis=Independent())
