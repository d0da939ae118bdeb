"""The space of a tuning: points of the unit cube ↔ values of a campaign.

    u ∈ [0, 1]^d ─range→ values of the free parameters ─ties→ values of all ─`--set`→ a campaign

A candidate is the campaign with some values set, read by the same rules as every campaign: nothing can be tuned that could not be
written into the file, and what is written in the end is what was flown.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign.plain_values import is_number
from rvjax.campaign.source import Source, read
from rvjax.campaign.tuning import Tuning
from rvjax.campaign.tuning_parameters import Free, Parameter, Product, Value, digits, is_free
from rvjax.components.search_methods.interface import Axis
from rvjax.components.settings import setting
from rvjax.errors import CampaignError, Finding
from rvjax.simulation.problem import Problem, load

ENDS = 2
"""Of a range, each of which is tried before anything flies."""


@dataclass(frozen=True)
class Space:
    """source, overrides: the campaign as it is given; problem: what it states. Made by `of`."""

    source: Source
    overrides: tuple[str, ...]
    problem: Problem
    parameters: Mapping[str, Parameter]
    fixed: Mapping[str, float]

    @classmethod
    def of(cls, path: str | Path | Source, overrides: Sequence[str] = ()) -> tuple[Space, Tuning]:
        """The space of a campaign with a section `tune`. CampaignError with every finding: no such section, places that are none,
        ends of ranges that the campaign refuses."""
        given = path if isinstance(path, Source) else read(path)
        problem = load(given, overrides)
        source, tuning = problem.spec.source, problem.spec.tune
        if tuning is None:
            accepted = "accepted: a section tune with parameters and an objective"
            raise CampaignError([source.finding((), "there is nothing to tune", accepted)])
        fixed, findings = _fixed(problem, tuning.parameters)
        space = cls(given, tuple(overrides), problem, tuning.parameters, fixed)
        findings += [*_aside(problem, tuning.parameters), *_unused(problem, tuning.parameters)]
        findings += space._refused() if not findings else []
        if findings:
            raise CampaignError(dict.fromkeys(findings))
        return space, tuning

    @cached_property
    def free(self) -> dict[str, Free]:
        """The parameters with a coordinate, in the order of the coordinates."""
        return {name: parameter for name, parameter in self.parameters.items() if is_free(parameter)}

    @property
    def axes(self) -> tuple[Axis, ...]:
        """What a search needs to know of each coordinate."""
        return tuple(Axis(parameter.levels, parameter.ordered) for parameter in self.free.values())

    def values(self, point: NDArray[np.float64], exact: bool = False) -> dict[str, Value]:
        """The value of every parameter at a point, as it is written; exact: with all digits."""
        free = zip(self.free.items(), map(float, point), strict=True)
        known: dict[str, Value] = {name: parameter.exact(u) if exact else parameter.value(u) for (name, parameter), u in free}
        return {
            name: self._product(parameter, known, exact) if isinstance(parameter, Product) else known[name]
            for name, parameter in self.parameters.items()
        }

    def _product(self, tie: Product, known: Mapping[str, Value], exact: bool) -> float:
        factors = [
            known.get(factor, self.fixed.get(factor, factor)) if isinstance(factor, str) else factor for factor in tie.factors
        ]
        product = float(np.prod([float(factor) for factor in factors]))
        return product if exact else digits(product)

    def assignments(self, values: Mapping[str, Value]) -> tuple[str, ...]:
        """The values as `place=value`; a name that is no place has none."""
        return tuple(f"{name}={json.dumps(value)}" for name, value in values.items() if is_place(name))

    def load(self, values: Mapping[str, Value]) -> Problem:
        """The campaign with these values. CampaignError where it refuses them together."""
        return self.problem.with_values({name: value for name, value in values.items() if is_place(name)})

    def of_search(self, path: Path, *more: str) -> Space:
        """The same, of another file with the same text, and with further overrides: nobody edits the copy in a folder."""
        given, overrides = read(path), (*self.overrides, *more)
        return replace(self, source=given, overrides=overrides, problem=load(given, overrides))

    @cached_property
    def original(self) -> dict[str, Value]:
        """The values of the original campaign, as far as they are fixed."""
        values = {name: setting(self.problem.spec, name) for name in self.parameters if is_place(name)}
        return {name: value for name, value in values.items() if value is not None}

    @property
    def start(self) -> NDArray[np.float64] | None:
        """The point with the original values, 0.5 where there is none; None where a value is outside its range."""
        point = [0.5] * len(self.free)
        for index, (name, parameter) in enumerate(self.free.items()):
            if name in self.original:
                inside = parameter.coordinate(self.original[name])
                if inside is None:
                    return None
                point[index] = inside
        return np.array(point)

    def _refused(self) -> list[Finding]:
        """Findings on ends of ranges that the campaign does not accept."""
        findings: dict[tuple[str, str], Finding] = {}
        middle = np.full(len(self.free), 0.5) if self.start is None else self.start
        for index, (name, parameter) in enumerate(self.free.items()):
            count = parameter.levels if parameter.levels and not parameter.ordered else ENDS
            for u in (np.arange(count) + 0.5) / count if parameter.levels else (0.0, 1.0):
                point = middle.copy()
                point[index] = u
                values = self.values(point)
                try:
                    self.load(values)
                except CampaignError as error:
                    for finding in (self._at_parameter(finding, name, values) for finding in error.findings):
                        findings.setdefault((finding.path, finding.accepted), finding)
        return list(findings.values())

    def _at_parameter(self, finding: Finding, name: str, values: Mapping[str, Value]) -> Finding:
        """A finding on a candidate, moved to the parameter that varies or that is tied to it."""
        other = next((tied for tied in values if finding.path.startswith(tied)), name)
        place = ("tune", "parameters", other)
        where = self.problem.spec.source.where(place, key=True)
        prefix = f"{other}={values[other]}: " if is_place(other) else ""
        about = f"{finding.path}: " if finding.path and finding.path != other else ""
        return replace(finding, where=where, path=".".join(place), found=f"{prefix}{about}{finding.found}")


def is_place(name: str) -> bool:
    """Whether a parameter is a place of the campaign; else it is a name for ties."""
    return "." in name


ASIDE = (
    *("audit", "baselines", "correlate", "description", "engine", "epistemic", "keep", "laws", "name", "precision", "require"),
    *("rvjax", "sampler", "tune"),
)
"""Parts of a campaign that no flight of a candidate depends on, or that all candidates have in common."""


def _aside(problem: Problem, parameters: Mapping[str, Parameter]) -> list[Finding]:
    """Places that nothing flies with, or that decide who is compared with whom."""
    lost = [name for name in parameters if is_place(name) and name.partition(".")[0] in ASIDE]
    accepted = "accepted: what a flight depends on, such as controller.gains.k1"
    place, source = ("tune", "parameters"), problem.spec.source
    return [source.finding((*place, name), f"{name} cannot be tuned", accepted, key=True) for name in lost]


def _fixed(problem: Problem, parameters: Mapping[str, Parameter]) -> tuple[dict[str, float], list[Finding]]:
    """The numbers of the campaign that ties name."""
    source, fixed = problem.spec.source, dict[str, float]()
    findings: list[Finding] = []
    for name, parameter in parameters.items():
        for index, factor in enumerate(parameter.factors if isinstance(parameter, Product) else ()):
            if not isinstance(factor, str) or factor in parameters:
                continue
            value = setting(problem.spec, factor)
            if is_number(value):
                fixed[factor] = value
            else:
                accepted = "accepted: another parameter, a number, or a place with a fixed number"
                place = ("tune", "parameters", name, "product", index)
                findings.append(source.finding(place, f"{factor} is no fixed number of the campaign", accepted))
    return fixed, findings


def _unused(problem: Problem, parameters: Mapping[str, Parameter]) -> list[Finding]:
    """Names that nothing is tied to."""
    used = {factor for parameter in parameters.values() if isinstance(parameter, Product) for factor in parameter.factors}
    lost = [name for name in parameters if not is_place(name) and name not in used]
    accepted = "accepted: a place such as controller.gains.k1, or a name that a product has as a factor"
    place = ("tune", "parameters")
    return [
        problem.spec.source.finding((*place, name), f"{name} is no place and nothing is tied to it", accepted, key=True)
        for name in lost
    ]
