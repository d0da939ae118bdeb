"""Sobol: u = (k + v)/2³⁰; k: the sample's point of a scrambled Sobol sequence, v: stream of the variable at the sample.

The first 2^m samples are spread evenly over the cube, so use a power of two (I. Sobol 1967; S. Joe, F. Kuo, SIAM J. Sci. Comput.
30, 2008; scrambling: J. Matoušek 1998). A variable has a dimension for each uniform number of its distribution. Dimensions are in
the order of the names, so another variable changes the samples. Samples are not independent, so this design is for exploration
and gives no verdict.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.stats import qmc

from rvjax.campaign import Model
from rvjax.campaign.problems import Problem
from rvjax.components.samplers.interface import PLACE, Samples, Sampling, Scheme, Setting, Values, of_stratum
from rvjax.stats.random_streams import uniforms
from rvjax.stats.sampling_design import Exploration

BITS = 30
MOST_DIMENSIONS = qmc.Sobol.MAXDIM


class Parameters(Model):
    """No parameters."""


@dataclass(frozen=True)
class Sobol:
    """A scrambled Sobol sequence. first: first dimension of each variable; dimensions: of all variables."""

    seed: int
    first: Mapping[str, int]
    dimensions: int

    @classmethod
    def of(cls, setting: Setting) -> Sobol:
        """The sequence for the variables of a campaign."""
        first, dimensions = dict[str, int](), 0
        for name, variable in sorted(setting.names.drawn.items()):
            first[name] = dimensions
            dimensions += variable.law.uniforms
        return cls(setting.seed, first, dimensions)

    def at(self, samples: Samples) -> Cube:
        """The points of some samples in all dimensions."""
        wanted, place = np.unique(samples, return_inverse=True)
        return Cube(self, samples, self._points(wanted)[place])

    def _points(self, ascending: Samples) -> Values:
        """(samples, dimensions) points of the sequence, whole numbers below 2^BITS."""
        points = np.empty((len(ascending), self.dimensions))
        if not self.dimensions:
            return points
        secret = int.from_bytes(hashlib.sha256(f"{self.seed}:sobol".encode()).digest()[:16], "little")
        generator = np.random.Generator(np.random.Philox(np.random.SeedSequence(secret)))
        make: Any = qmc.Sobol  # `rng` to type checkers, which releases before 1.15 do not know
        sequence = make(self.dimensions, scramble=True, bits=BITS, seed=generator)
        done = 0
        for rows in np.split(np.arange(len(ascending)), np.flatnonzero(np.diff(ascending) != 1) + 1):
            for part in (rows[:1], rows[1:]):  # the first point alone, because SciPy wants a power of two for the rest
                if part.size:
                    if int(ascending[part[0]]) > done:
                        sequence.fast_forward(int(ascending[part[0]]) - done)
                    points[part] = sequence.random(len(part)) * 2.0**BITS
                    done = int(ascending[part[-1]]) + 1
        return np.floor(points)


@dataclass(frozen=True)
class Cube:
    """The points of some samples."""

    sequence: Sobol
    samples: Samples
    points: Values = field(repr=False)

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1). A name that is no variable, such as a choice in a schedule, has its stream."""
        inside = uniforms(self.sequence.seed, name, self.samples)[:, :count]
        if name not in self.sequence.first:
            return inside
        first = self.sequence.first[name]
        return of_stratum(self.points[:, first : first + count], inside, 2.0**BITS)

    def prescribed(self, name: str) -> None:
        """No draw is prescribed."""


def _problems(setting: Setting) -> Iterable[Problem]:
    dimensions = sum(variable.law.uniforms for variable in setting.names.drawn.values())
    if dimensions > MOST_DIMENSIONS:
        yield Problem(f"{dimensions:,} dimensions", f"accepted: at most {MOST_DIMENSIONS:,}", PLACE)


COMPONENT = Sampling(
    Parameters, lambda parameters: Scheme(Sobol.of, _problems), design=Exploration(), packages=("numpy", "scipy")
)
