"""The dispersions of a campaign: its variables, the correlated groups, and the redrawn bodies.

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
from rvjax.components.samplers.interface import PLACE, NoiseSampler, Points, Sampler, Samples, Scheme, Setting
from rvjax.errors import CampaignError, Finding
from rvjax.simulation.inertia import bodies
from rvjax.simulation.rejection_sampling import LEAST_ACCEPTED, Retry, retries
from rvjax.stats.sampling_design import Independent


@dataclass(frozen=True)
class Dispersions:
    """variables: by name of their stream. groups: of correlated variables. retries: bodies that are redrawn together.

    extends: whether a run can be extended by more samples. columns: the meaning of every draw, by name.
    """

    variables: Mapping[str, Variable]
    seed: int
    sampler: Sampler
    groups: tuple[Group, ...]
    retries: tuple[Retry, ...]
    extends: bool
    columns: Mapping[str, Column]

    def at(self, samples: Samples) -> tuple[Points, dict[str, NDArray[np.int64]]]:
        """The points of these samples, and the number of rejected draws of each, by name of the column."""
        points = self.sampler.at(samples)
        rejected: dict[str, NDArray[np.int64]] = {}
        for retry in self.retries:
            points, counts = retry.hold(points, self.groups, self.seed, self.noise(samples, next(iter(retry.counts), "")))
            rejected |= {f"{body.path}.rejected": counts for body in retry.bodies}
        return Correlated(points, self.groups), rejected

    def noise(self, samples: Samples, stream: str) -> Samples:
        """(samples,) the samples whose noise of a stream these samples have: the same, unless the sampler says otherwise."""
        return self.sampler.noise(samples, stream) if isinstance(self.sampler, NoiseSampler) else samples


def resolve(spec: Spec, quantities: Mapping[str, Quantity], scheme: Scheme) -> Dispersions:
    """The dispersions of a campaign. quantities: drawn or fixed, by name. scheme: of its sampler.

    Errors: CampaignError with every finding about names and groups.
    """
    names = Names(quantities)
    setting = Setting(spec.seed, spec.samples, names)
    findings = [*_groups(spec, names), *_unknown_kinds(spec, names), *_unjudgeable(spec)]
    findings += [spec.source.finding(p.place, p.message, p.accepted, p.at_key) for p in scheme.problems(setting)]
    if findings:
        raise CampaignError(findings)
    groups = tuple(Group.of(correlation) for correlation in spec.correlate)
    again = retries(bodies(spec), groups, names.drawn)
    if findings := [*_given_twice(spec, scheme, groups, again), *_seldom(spec, again, groups)]:
        raise CampaignError(findings)
    columns = _columns(spec, names.drawn, again)
    return Dispersions(names.drawn, spec.seed, scheme.make(setting), groups, again, scheme.extends, columns)


def _groups(spec: Spec, names: Names) -> Iterator[Finding]:
    """Findings about correlated groups: unknown names, and names in two places."""
    first: dict[str, str] = {}
    for index, group in enumerate(spec.correlate):
        for position, name in enumerate(group.variables):
            place = ("correlate", index, "variables", position)
            if wrong := names.scalar(name):
                yield spec.source.finding(place, *wrong)
            elif name in first:
                accepted = f"accepted: each variable once; the first is at {first[name]}"
                yield spec.source.finding(place, f"{name} is listed twice", accepted)
            else:
                first[name] = spec.source.where(place)
        if all(name in names.drawn for name in group.variables):
            laws = {name: names.drawn[name].law for name in group.variables}
            for problem in group.law_problems(laws):
                below = problem.below(("correlate", index))
                yield spec.source.finding(below.place, below.message, below.accepted)


def _unknown_kinds(spec: Spec, names: Names) -> Iterator[Finding]:
    """Findings about unknown names of epistemic draws."""
    for index, name in enumerate(spec.epistemic):
        if wrong := names.beginning(name):
            yield spec.source.finding(("epistemic", index), *wrong)


def _unjudgeable(spec: Spec) -> Iterator[Finding]:
    """A finding about requirements if the samples allow no verdicts."""
    if spec.require and not isinstance(sampling_design_of(spec), Independent):
        message = f"requirements on samples of {spec.sampler.use}, which are not independent"
        accepted = "accepted: none, or sampler: {use: monte-carlo}"
        yield spec.source.finding(("require",), message, accepted, key=True)


def _given_twice(spec: Spec, scheme: Scheme, groups: Iterable[Group], again: Iterable[Retry]) -> Iterator[Finding]:
    """Findings about draws whose values the sampler sets, but that are also correlated or redrawn."""
    correlated = {name for group in groups for name in group.names}
    redrawn = {name for retry in again for name in retry.draws}
    for name in scheme.prescribed:
        if name in correlated or name in redrawn:
            why = "is correlated with others" if name in correlated else "is redrawn if it is unphysical (reject)"
            yield spec.source.finding(
                PLACE, f"{name} has its values from {spec.sampler.use}, but {why}", "accepted: one of the two"
            )


def _columns(spec: Spec, drawn: Mapping[str, Variable], again: Iterable[Retry]) -> dict[str, Column]:
    """The meaning of every draw, and of every count of rejected draws."""
    correlated = {name for group in spec.correlate for name in group.variables}
    columns: dict[str, Column] = {}
    for variable in drawn.values():
        law = in_words(variable.law) + (", correlated" if variable.name in correlated else "")
        for name in variable.draws:
            kind = EPISTEMIC if any(covers(beginning, name) for beginning in spec.epistemic) else ALEATORY
            columns[name] = Column(draw_column(name), variable.unit, variable.doc, kind=kind, law=law)
    for path in (f"{body.path}.rejected" for retry in again for body in retry.bodies):
        columns[path] = Column(draw_column(path), "1", "draws rejected as unphysical")
    return columns


def _seldom(spec: Spec, again: Iterable[Retry], groups: tuple[Group, ...]) -> Iterator[Finding]:
    """Findings about bodies of which hardly any draw is physical."""
    for retry in again:
        share = retry.accepted(groups)
        if share < LEAST_ACCEPTED:
            message = f"about {100.0 * share:.2g} % of the draws are physical"
            accepted = f"accepted: distributions of which {100.0 * LEAST_ACCEPTED:g} % or more are"
            yield spec.source.finding(tuple(retry.bodies[-1].path.split(".")), message, accepted)
