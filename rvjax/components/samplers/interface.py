"""Interface of a sampler: for a variable and some samples, it gives the numbers that decide their draws.

A member of the family is a `Sampling`: parameters, a function that builds a `Scheme` from them, and the sampling design.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign.draw_names import Names
from rvjax.campaign.problems import Problem
from rvjax.components.registry import Component, P
from rvjax.stats.random_streams import uniforms
from rvjax.stats.sampling_design import Exploration, SamplingDesign

Values = NDArray[np.float64]
Samples = NDArray[np.int64]


class Points(Protocol):
    """Some samples of a campaign, before their draws."""

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1) of a variable, which its distribution turns into draws."""
        ...

    def prescribed(self, name: str) -> Values | None:
        """(samples,) values of a draw, if the sampler prescribes values in place of uniform numbers; else None."""
        ...


class Sampler(Protocol):
    """Gives the points of any samples, in any order."""

    def at(self, samples: Samples) -> Points:
        """The points of some samples."""
        ...


@runtime_checkable
class NoiseSampler(Sampler, Protocol):
    """A sampler that also says whose noise in flight, and whose redrawn numbers, its samples have."""

    def noise(self, samples: Samples, stream: str) -> Samples:
        """(samples,) the samples whose numbers of this stream some samples have."""
        ...


@dataclass(frozen=True)
class Setting:
    """What a sampler needs to know of its campaign. samples: number of samples; names: of the draws."""

    seed: int
    samples: int
    names: Names


@dataclass(frozen=True)
class Scheme:
    """A sampler before the campaign is known.

    make(setting) → the sampler, if problems(setting) is empty; places are those of the whole campaign. prescribed: names of the
    draws whose values the sampler prescribes. extends: whether a larger number of samples keeps the samples of a smaller number.
    """

    make: Callable[[Setting], Sampler]
    problems: Callable[[Setting], Iterable[Problem]] = lambda setting: ()
    prescribed: tuple[str, ...] = ()
    extends: bool = True


@dataclass(frozen=True)
class Sampling(Component[P]):
    """A sampler. design: whether its samples are independent; those of a user's file count as exploration, whatever it says.

    packages: distributions whose version may change its numbers.
    """

    family: ClassVar[str] = "samplers"

    design: SamplingDesign = field(default=Exploration(), kw_only=True)
    packages: tuple[str, ...] = field(default=(), kw_only=True)


PLACE = ("sampler",)
"""Place of the sampler in a campaign."""


def of_stratum(stratum: Values, inside: Values, count: float) -> Values:
    """u = (k + v)/n: the number at v ∈ (0, 1) in stratum k of n, strictly inside it in spite of rounding."""
    low, high = np.nextafter(stratum / count, 1.0), np.nextafter((stratum + 1.0) / count, 0.0)
    return np.clip((stratum + inside) / count, low, high)


@dataclass(frozen=True)
class Streams:
    """The random streams of some samples. values: of the prescribed draws."""

    seed: int
    samples: Samples
    values: Mapping[str, Values]

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1)."""
        return uniforms(self.seed, name, self.samples)[:, :count]

    def prescribed(self, name: str) -> Values | None:
        """(samples,) values of a prescribed draw, else None."""
        return self.values.get(name)
