"""Monte Carlo: u = random stream of the variable at the sample, independent of all other variables and samples.

The default. Samples are independent draws from the campaign's distributions, so bounds and verdicts hold. Streams:
`rvjax.stats.random_streams`.
"""

from __future__ import annotations

from dataclasses import dataclass

from rvjax.campaign import Model
from rvjax.components.samplers.interface import Samples, Sampling, Scheme, Streams
from rvjax.stats.sampling_design import Independent


class Parameters(Model):
    """No parameters."""


@dataclass(frozen=True)
class MonteCarlo:
    """Independent streams."""

    seed: int

    def at(self, samples: Samples) -> Streams:
        """The points of some samples."""
        return Streams(self.seed, samples, {})


COMPONENT = Sampling(Parameters, lambda parameters: Scheme(lambda setting: MonteCarlo(setting.seed)), design=Independent())
