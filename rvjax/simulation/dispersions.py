"""How the numbers of a campaign are drawn: which variables there are, which are correlated, which are drawn again.

Spec, quantities ─resolve→ Dispersions ─at→ Points of samples ─draw→ …
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Quantity, Spec
from rvjax.campaign.draw_names import Names, covers
from rvjax.campaign.law_words import in_words
from rvjax.campaign.variables import Variable
from rvjax.columns import ALEATORY, EPISTEMIC, Column, draw_column
from rvjax.components.samplers import sampling_design_of
from rvjax.components.samplers.copula import Correlated, Group
from rvjax.components.samplers.interface import PLACE, Points, Sampler, Samples, Scheme, Setting
from rvjax.errors import CampaignError, Finding
from rvjax.simulation.inertia import bodies
from rvjax.simulation.rejection_sampling import LEAST_ACCEPTED, Retry, retries
from rvjax.stats.sampling_design import Independent


@dataclass(frozen=True)
class Dispersions:
    """variables: by the name of their stream; groups: of correlated ones; retries: what is drawn again together;
    extends: whether a run may go on with more samples; columns: the meaning of every draw, by name.
    """

    variables: Mapping[str, Variable]
    seed: int
    sampler: Sampler
    groups: tuple[Group, ...]
    retries: tuple[Retry, ...]
    extends: bool
    columns: Mapping[str, Column]

    def at(self, samples: Samples) -> tuple[Points, dict[str, NDArray[np.int64]]]:
        """What decides the draws of some samples, and how many draws of each were rejected, by name of the column."""
        points = self.sampler.at(samples)
        rejected: dict[str, NDArray[np.int64]] = {}
        for retry in self.retries:
            points, counts = retry.hold(points, self.groups, self.seed, samples)
            rejected |= {f"{body.path}.rejected": counts for body in retry.bodies}
        return Correlated(points, self.groups), rejected


def resolve(spec: Spec, quantities: Mapping[str, Quantity], scheme: Scheme) -> Dispersions:
    """quantities: all that a campaign draws or fixes, by name. scheme: what its sampler makes.

    Errors: CampaignError with every finding about the names and groups that the campaign says.
    """
    names = Names(quantities)
    setting = Setting(spec.seed, spec.samples, names)
    findings = [*_groups(spec, names), *_unknown_kinds(spec, names), *_unjudgeable(spec)]
    findings += [spec.source.finding(one.place, one.found, one.accepted, one.at_key) for one in scheme.wrong(setting)]
    if findings:
        raise CampaignError(findings)
    groups = tuple(Group.of(one) for one in spec.correlate)
    again = retries(bodies(spec), groups, names.drawn)
    if findings := [*_given_twice(spec, scheme, groups, again), *_seldom(spec, again, groups)]:
        raise CampaignError(findings)
    columns = _columns(spec, names.drawn, again)
    return Dispersions(names.drawn, spec.seed, scheme.make(setting), groups, again, scheme.extends, columns)


def _groups(spec: Spec, names: Names) -> Iterator[Finding]:
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


def _unknown_kinds(spec: Spec, names: Names) -> Iterator[Finding]:
    """Findings about names of epistemic draws that are none."""
    for index, name in enumerate(spec.epistemic):
        if wrong := names.beginning(name):
            yield spec.source.finding(("epistemic", index), *wrong)


def _unjudgeable(spec: Spec) -> Iterator[Finding]:
    """Requirements on samples that no verdict can be issued on."""
    if spec.require and not isinstance(sampling_design_of(spec), Independent):
        found = f"requirements on samples of {spec.sampler.use}, which are not independent"
        accepted = "accepted: none, or sampler: {use: monte-carlo}"
        yield spec.source.finding(("require",), found, accepted, key=True)


def _given_twice(spec: Spec, scheme: Scheme, groups: Iterable[Group], again: Iterable[Retry]) -> Iterator[Finding]:
    """Findings about draws whose values the sampler says, and something else as well."""
    correlated = {name for group in groups for name in group.names}
    redrawn = {name for retry in again for name in retry.draws}
    for name in scheme.given:
        if name in correlated or name in redrawn:
            why = "is correlated with others" if name in correlated else "is drawn again where no body can have it (reject)"
            yield spec.source.finding(
                PLACE, f"{name} has its values from {spec.sampler.use}, but {why}", "accepted: one of the two"
            )


def _columns(spec: Spec, drawn: Mapping[str, Variable], again: Iterable[Retry]) -> dict[str, Column]:
    """The meaning of every draw, and of every count of rejected ones."""
    correlated = {name for group in spec.correlate for name in group.variables}
    found: dict[str, Column] = {}
    for variable in drawn.values():
        law = in_words(variable.law) + (", correlated" if variable.name in correlated else "")
        for name in variable.draws:
            kind = EPISTEMIC if any(covers(one, name) for one in spec.epistemic) else ALEATORY
            found[name] = Column(draw_column(name), variable.unit, variable.doc, kind=kind, law=law)
    for path in (f"{body.path}.rejected" for retry in again for body in retry.bodies):
        found[path] = Column(draw_column(path), "1", "draws before this one that no body can have")
    return found


def _seldom(spec: Spec, again: Iterable[Retry], groups: tuple[Group, ...]) -> Iterator[Finding]:
    """Findings about bodies of which hardly any draw can exist."""
    for retry in again:
        share = retry.accepted(groups)
        if share < LEAST_ACCEPTED:
            found = f"about {100.0 * share:.2g} % of the draws are of bodies that can exist"
            accepted = f"accepted: distributions of which {100.0 * LEAST_ACCEPTED:g} % or more are"
            yield spec.source.finding(tuple(retry.bodies[-1].path.split(".")), found, accepted)
