"""How the numbers of a campaign are drawn: which variables there are, which are correlated, which are drawn again.

Spec, quantities ─resolve→ Dispersions ─at→ Points of samples ─draw→ …
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rvjax.bodies import bodies
from rvjax.errors import CampaignError, Finding
from rvjax.retries import LEAST_ACCEPTED, Retry, retries
from rvjax.samplers.copula import Correlated, Group
from rvjax.samplers.interface import Points, Sampler, Samples
from rvjax.samplers.monte_carlo import MonteCarlo
from rvjax.spec import Quantity, Spec
from rvjax.spec.notation import did_you_mean
from rvjax.spec.values import shorten
from rvjax.spec.variables import Variable, variables


@dataclass(frozen=True)
class Dispersions:
    """variables: by the name of their stream; groups: of correlated ones; retries: what is drawn again together."""

    variables: Mapping[str, Variable]
    seed: int
    sampler: Sampler
    groups: tuple[Group, ...]
    retries: tuple[Retry, ...]

    def at(self, samples: Samples) -> tuple[Points, dict[str, NDArray[np.int64]]]:
        """What decides the draws of some samples, and how many draws of each were rejected, by name of the column."""
        points = self.sampler.at(samples)
        rejected: dict[str, NDArray[np.int64]] = {}
        for retry in self.retries:
            points, counts = retry.hold(points, self.groups, self.seed, samples)
            rejected |= {f"{body.path}.rejected": counts for body in retry.bodies}
        return Correlated(points, self.groups), rejected


def resolve(spec: Spec, quantities: Mapping[str, Quantity]) -> Dispersions:
    """quantities: all that a campaign draws or fixes, by name.

    Errors: CampaignError with every finding about the names and groups that the campaign says.
    """
    drawn = variables(quantities)
    names = _Names(drawn, quantities)
    findings = [*_groups(spec, names)]
    if findings:
        raise CampaignError(findings)
    groups = tuple(Group.of(one) for one in spec.correlate)
    again = retries(bodies(spec), groups, drawn)
    if findings := [*_seldom(spec, again, groups)]:
        raise CampaignError(findings)
    return Dispersions(drawn, spec.seed, MonteCarlo(spec.seed), groups, again)


class _Names:
    """The names that a campaign may say of its draws."""

    def __init__(self, drawn: Mapping[str, Variable], quantities: Mapping[str, Quantity]) -> None:
        self.variable = {name: variable for variable in drawn.values() for name in variable.draws}
        self._fixed = {own for name, quantity in quantities.items() for own in quantity.names(name)}.difference(self.variable)

    def scalar(self, name: str) -> tuple[str, str] | None:
        """What is found and accepted where a name is not that of a draw with a law of its own."""
        if name in self.variable:
            law = self.variable[name].law
            together = f"{shorten(name)} is drawn together with the others of {self.variable[name].name}"
            return (
                None if len(self.variable[name].draws) == 1 else (together, f"accepted: a draw with a law of its own, not {law}")
            )
        if name in self._fixed:
            return f"{shorten(name)} is not drawn, it is fixed", "accepted: the name of a draw"
        return f"{shorten(name)} is no draw", did_you_mean(
            name, [own for own, one in self.variable.items() if len(one.draws) == 1]
        )


def _groups(spec: Spec, names: _Names) -> Iterator[Finding]:
    """Findings about correlated groups: names that are none, and names that stand in two places."""
    first: dict[str, str] = {}
    for index, group in enumerate(spec.correlate):
        for position, name in enumerate(group.variables):
            place = ("correlate", index, "variables", position)
            if wrong := names.scalar(name):
                yield spec.source.finding(place, *wrong)
            elif name in first:
                accepted = f"accepted: each variable once; the first is at {first[name]}"
                yield spec.source.finding(place, f"{name} stands twice", accepted)
            else:
                first[name] = spec.source.where(place)


def _seldom(spec: Spec, again: Iterable[Retry], groups: tuple[Group, ...]) -> Iterator[Finding]:
    """Findings about bodies of which hardly any draw can exist."""
    for retry in again:
        share = retry.accepted(groups)
        if share < LEAST_ACCEPTED:
            found = f"about {100.0 * share:.2g} % of the draws are of bodies that can exist"
            accepted = f"accepted: distributions of which {100.0 * LEAST_ACCEPTED:g} % or more are"
            yield spec.source.finding(tuple(retry.bodies[-1].path.split(".")), found, accepted)
