"""Bodies that cannot exist are drawn again, until one can: what flies has the campaign's law, given that there is such a body.

    u⁽⁰⁾ = the sampler's,   u⁽ᵏ⁾ = the stream `name.again.k`,   k = 1, 2, … up to the first draw that a body can have

Everything that decides whether a body exists is drawn again together, with whatever is correlated with it. Numbers depend on
(seed, name, sample) only.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Quantity
from rvjax.campaign.variables import Variable, variables
from rvjax.components.samplers.copula import Correlated, Group
from rvjax.components.samplers.interface import Points, Samples, Values
from rvjax.components.samplers.monte_carlo import MonteCarlo
from rvjax.errors import UsageError
from rvjax.simulation.inertia import Body
from rvjax.stats.random_streams import uniforms

MOST = 100_000
"""Draws of one sample, after which the campaign is given up; at the least share that is accepted, that happens to nobody."""

LEAST_ACCEPTED = 0.02
TRIED = 4096
"""Draws that tell beforehand which share is accepted."""


@dataclass(frozen=True)
class Retry:
    """Bodies that are drawn again together, and the variables that are: counts, how many uniform numbers each takes, by name;
    draws: names of the draws."""

    bodies: tuple[Body, ...]
    counts: Mapping[str, int]
    draws: frozenset[str]

    def accepted(self, groups: Iterable[Group]) -> float:
        """The share of first draws that are accepted, of TRIED independent ones of a seed of their own."""
        samples = np.arange(TRIED, dtype=np.int64)
        return float(np.mean(self._exist(Correlated(MonteCarlo(0).at(samples), groups), TRIED)))

    def hold(self, points: Points, groups: tuple[Group, ...], seed: int, samples: Samples) -> tuple[Held, NDArray[np.int64]]:
        """Points with what is drawn again in place of what was rejected, and how often each sample was."""
        numbers = {name: np.array(points.uniforms(name, count)) for name, count in self.counts.items()}
        rejected = np.zeros(len(samples), dtype=np.int64)
        rows = np.arange(len(samples))
        for again in range(1, MOST):
            current = {name: block[rows] for name, block in numbers.items()}
            rows = rows[~self._exist(Correlated(Held(points, current), groups), len(rows))]
            if not rows.size:
                return Held(points, numbers), rejected
            rejected[rows] += 1
            for name, count in self.counts.items():
                numbers[name][rows] = uniforms(seed, f"{name}.again.{again}", samples[rows])[:, :count]
        paths = ", ".join(body.path for body in self.bodies)
        raise UsageError(f"{paths}: {MOST:,} draws of sample {samples[rows[0]]} were rejected; accepted: narrower distributions")

    def _exist(self, points: Points, count: int) -> NDArray[np.bool_]:
        def parts(name: str, quantity: Quantity) -> tuple[Values, ...]:
            return quantity.draw(name, points.uniforms, count)

        return np.all([body.exists(parts) for body in self.bodies], axis=0)


@dataclass(frozen=True)
class Held:
    """Points in which the numbers of some variables are given."""

    points: Points
    numbers: Mapping[str, Values] = field(repr=False)

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1)."""
        return self.numbers[name] if name in self.numbers else self.points.uniforms(name, count)

    def given(self, name: str) -> Values | None:
        """(samples,) values of a draw that the sampler says."""
        return self.points.given(name)


def retries(bodies: Iterable[Body], groups: Iterable[Group], drawn: Mapping[str, Variable]) -> tuple[Retry, ...]:
    """What is drawn again together: each body that rejects with its variables and all that is correlated with them."""
    found: list[tuple[tuple[Body, ...], set[str]]] = []
    for body in bodies:
        if not body.inertia.REJECTS:
            continue
        names = set(variables(body.quantities))
        for group in groups:
            if names & set(group.names):
                names |= set(group.names)
        shared = [one for one in found if one[1] & names]
        found = [one for one in found if not one[1] & names]
        together = (*(other for one in shared for other in one[0]), body)
        found.append((together, names.union(*(one[1] for one in shared))))
    return tuple(_retry(together, [drawn[name] for name in sorted(names)]) for together, names in found)


def _retry(together: tuple[Body, ...], again: Iterable[Variable]) -> Retry:
    again = list(again)
    counts = {variable.name: variable.law.uniforms for variable in again}
    return Retry(together, counts, frozenset(draw for variable in again for draw in variable.draws))
