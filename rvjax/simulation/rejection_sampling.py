"""Unphysical inertias are rejected and redrawn: the draws follow the campaign's distribution, given a physical body.

    u⁽⁰⁾ = the sampler's,   u⁽ᵏ⁾ = the stream `name.again.k`,   k = 1, 2, … up to the first physical draw

All variables that decide whether a body is physical are redrawn together, with all variables correlated with them. Numbers
depend on (seed, name, sample) only.
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
"""Draws of a sample before the run is abandoned. At the smallest accepted share this does not happen in practice."""

LEAST_ACCEPTED = 0.02
TRIED = 4096
"""Draws that estimate the accepted share beforehand."""


@dataclass(frozen=True)
class Retry:
    """Bodies that are redrawn together. counts: uniform numbers per redrawn variable, by name. draws: names of their draws."""

    bodies: tuple[Body, ...]
    counts: Mapping[str, int]
    draws: frozenset[str]

    def accepted(self, groups: Iterable[Group]) -> float:
        """The accepted share of TRIED independent draws of a separate seed."""
        samples = np.arange(TRIED, dtype=np.int64)
        return float(np.mean(self._exist(Correlated(MonteCarlo(0).at(samples), groups), TRIED)))

    def hold(self, points: Points, groups: tuple[Group, ...], seed: int, samples: Samples) -> tuple[Redrawn, NDArray[np.int64]]:
        """The points with rejected numbers redrawn, and (samples,) how often each sample was rejected."""
        numbers = {name: np.array(points.uniforms(name, count)) for name, count in self.counts.items()}
        rejected = np.zeros(len(samples), dtype=np.int64)
        rows = np.arange(len(samples))
        for again in range(1, MOST):
            current = {name: block[rows] for name, block in numbers.items()}
            rows = rows[~self._exist(Correlated(Redrawn(points, current), groups), len(rows))]
            if not rows.size:
                return Redrawn(points, numbers), rejected
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
class Redrawn:
    """Points with replaced numbers of some variables."""

    points: Points
    numbers: Mapping[str, Values] = field(repr=False)

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1)."""
        return self.numbers[name] if name in self.numbers else self.points.uniforms(name, count)

    def prescribed(self, name: str) -> Values | None:
        """(samples,) values of a draw that the sampler sets; None if it sets none."""
        return self.points.prescribed(name)


def retries(bodies: Iterable[Body], groups: Iterable[Group], drawn: Mapping[str, Variable]) -> tuple[Retry, ...]:
    """The groups that are redrawn together: each rejecting body with its variables and all variables correlated with them."""
    sets: list[tuple[tuple[Body, ...], set[str]]] = []
    for body in bodies:
        if not body.inertia.REJECTS:
            continue
        names = set(variables(body.quantities))
        for group in groups:
            if names & set(group.names):
                names |= set(group.names)
        joined = [entry for entry in sets if entry[1] & names]
        sets = [entry for entry in sets if not entry[1] & names]
        together = (*(other for others, _ in joined for other in others), body)
        sets.append((together, names.union(*(shared for _, shared in joined))))
    return tuple(_retry(together, [drawn[name] for name in sorted(names)]) for together, names in sets)


def _retry(together: tuple[Body, ...], again: Iterable[Variable]) -> Retry:
    again = list(again)
    counts = {variable.name: variable.law.uniforms for variable in again}
    return Retry(together, counts, frozenset(draw for variable in again for draw in variable.draws))
