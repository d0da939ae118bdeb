"""How the numbers of a campaign are drawn: which variables there are, which of them are correlated.

Spec, quantities ─resolve→ Dispersions ─at→ Points of samples ─draw→ …
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from rvjax.errors import CampaignError, Finding
from rvjax.samplers.copula import Correlated, Group
from rvjax.samplers.interface import Points, Sampler, Samples
from rvjax.samplers.monte_carlo import MonteCarlo
from rvjax.spec import Quantity, Spec
from rvjax.spec.notation import did_you_mean
from rvjax.spec.values import shorten
from rvjax.spec.variables import Variable, variables


@dataclass(frozen=True)
class Dispersions:
    """variables: by the name of their stream; groups: of correlated ones."""

    variables: Mapping[str, Variable]
    sampler: Sampler
    groups: tuple[Group, ...]

    def at(self, samples: Samples) -> Points:
        """What decides the draws of some samples."""
        return Correlated(self.sampler.at(samples), self.groups)


def resolve(spec: Spec, quantities: Mapping[str, Quantity]) -> Dispersions:
    """quantities: all that a campaign draws or fixes, by name.

    Errors: CampaignError with every finding about the names and groups that the campaign says.
    """
    drawn = variables(quantities)
    names = _Names(drawn, quantities)
    findings = [*_groups(spec, names)]
    if findings:
        raise CampaignError(findings)
    return Dispersions(drawn, MonteCarlo(spec.seed), tuple(Group.of(one) for one in spec.correlate))


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
