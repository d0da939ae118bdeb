"""What a sampler is: it gives, for the name of a variable and some samples, the numbers that decide their draws.

A member of the family is a `Sampling`: parameters of a campaign, what they make, and on which basis samples drawn so stand.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign.draw_names import Names
from rvjax.campaign.problems import Problem
from rvjax.components.registry import Component, P
from rvjax.stats.random_streams import uniforms
from rvjax.stats.sampling_design import SamplingDesign

Values = NDArray[np.float64]
Samples = NDArray[np.int64]


class Points(Protocol):
    """Some samples of a campaign, before their draws."""

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1) of a variable, which its law turns into its draws."""
        ...

    def given(self, name: str) -> Values | None:
        """(samples,) values of a draw, where the sampler says these and not numbers that its law turns into them."""
        ...


class Sampler(Protocol):
    """Gives the points of any samples, in any order and number."""

    def at(self, samples: Samples) -> Points:
        """The points of some samples."""
        ...


@dataclass(frozen=True)
class Setting:
    """What a campaign says beside its sampler. samples: how many there are to be."""

    seed: int
    samples: int
    names: Names


@dataclass(frozen=True)
class Scheme:
    """What the parameters of a sampler make.

    make(setting) → the sampler, if wrong(setting), with places in the whole campaign, finds nothing. given: names of the draws
    whose values it says. extends: whether samples of a larger number are those of a smaller one and further ones.
    """

    make: Callable[[Setting], Sampler]
    wrong: Callable[[Setting], Iterable[Problem]] = lambda setting: ()
    given: tuple[str, ...] = ()
    extends: bool = True


@dataclass(frozen=True)
class Sampling(Component[P]):
    """basis: what may be said of samples that are drawn so."""

    basis: SamplingDesign = field(kw_only=True)


PLACE = ("sampler",)
"""Of the sampler in a campaign."""


def of_stratum(stratum: Values, inside: Values, count: float) -> Values:
    """u = (k + v)/n: the number in stratum k of n at v ∈ (0, 1), strictly inside it whatever rounding does."""
    low, high = np.nextafter(stratum / count, 1.0), np.nextafter((stratum + 1.0) / count, 0.0)
    return np.clip((stratum + inside) / count, low, high)


@dataclass(frozen=True)
class Streams:
    """The streams of some samples; values: of the draws that are given."""

    seed: int
    samples: Samples
    values: Mapping[str, Values]

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1)."""
        return uniforms(self.seed, name, self.samples)[:, :count]

    def given(self, name: str) -> Values | None:
        """Those of the values."""
        return self.values.get(name)
