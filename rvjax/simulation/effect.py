"""Inputs of a campaign that change nothing in any sample, and inputs that the steps cannot follow, decided without a flight.

Drawn inputs that change nothing need a flight: `rvjax.execution.audit`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rvjax.campaign.draw_names import covers
from rvjax.campaign.plain_values import Place, exact
from rvjax.campaign.problems import Problem as Wrong
from rvjax.campaign.requirement import Condition
from rvjax.components.effect import neutral_values
from rvjax.components.faults import effect as faults
from rvjax.components.faults.interface import FaultParameters
from rvjax.errors import Finding
from rvjax.simulation.problem import Part, Problem


class Silent(NamedTuple):
    """name: of the input, for `audit.allow`; finding: why it changes nothing in any sample."""

    name: str
    finding: Finding


def silent(problem: Problem) -> list[Silent]:
    """Every input whose numbers show that it changes nothing in any sample."""
    looked_at = (*parts(problem), *problem.chosen)
    found = [(_name(part, wrong.place), part.place, wrong) for part in looked_at for wrong in _problems(problem, part)]
    found += [(".".join(map(str, wrong.place)), (), wrong) for wrong in (*_corridor(problem), *_bodies(problem))]
    found += [(".".join(map(str, wrong.place)), (), wrong) for wrong in _classes(problem)]
    source = problem.spec.source
    return [
        Silent(
            name,
            source.finding(
                (*place, *wrong.place), f"{name} does nothing: {wrong.message}", f"{wrong.accepted}, or {name} under audit.allow"
            ),
        )
        for name, place, wrong in found
    ]


def refused(problem: Problem) -> list[Finding]:
    """The findings on those that are not in `audit.allow`."""
    return [finding for name, finding in silent(problem) if not allowed(problem, name)]


def allowed(problem: Problem, name: str) -> bool:
    """Whether `audit.allow` permits that an input has no effect."""
    return any(covers(beginning, name) for beginning in problem.spec.audit.allow)


def warnings(problem: Problem) -> list[Finding]:
    """What the steps of the integration cannot follow. The campaign flies all the same."""
    idle = {name for name, _ in silent(problem)}
    source = problem.spec.source
    return [
        source.finding((*part.place, *wrong.place), wrong.message, wrong.accepted)
        for part in parts(problem)
        if part.component is not None and part.parameters is not None and part.prefix not in idle
        for wrong in part.component.coarse(part.parameters, problem.spec)
    ]


def parts(problem: Problem) -> tuple[Part, ...]:
    """The components that change a flight or a measurement."""
    return (*problem.faults, *problem.disturbances, *problem.navigation)


def _name(part: Part, place: Place) -> str:
    """The name of a component, or of a channel or group of a fault."""
    match place:
        case ("channels", int(index)) if isinstance(part.parameters, FaultParameters):
            return f"{part.prefix}.channels.{part.parameters.channels[index]}"
        case ("schedule", "groups", index):
            return f"{part.prefix}.schedule.groups.{index}"
        case _:
            return part.prefix


def _problems(problem: Problem, part: Part) -> Iterator[Wrong]:
    """Why a component, or a part of it, changes nothing."""
    member, parameters = part.component, part.parameters
    if member is None or parameters is None:
        return
    if isinstance(parameters, FaultParameters):
        yield from faults.problems(parameters, member.neutral, problem.spec)
    elif words := neutral_values(parameters, member.neutral):
        yield Wrong(words, "accepted: another value")
    else:
        yield from member.silent(parameters, problem.spec)


def _corridor(problem: Problem) -> Iterator[Wrong]:
    """Without target.port_axis the approach cone has its axis through the docking point; without an offset there is none."""
    source, target, spec = problem.spec.source, problem.spec.target, problem.spec
    if not target.has_docking_axis:
        places = [("corridor",)] * bool(source.value and source.value.get("corridor"))
        places += [("target", "keep_out")] * (target.keep_out is not None)
        accepted = "accepted: another target.port_m, or a target.port_axis"
        for place in places:
            yield Wrong("target.port_m is 0, so there is no docking axis", accepted, place)
    elif spec.corridor.length_m is not None and spec.corridor.length_m <= spec.capture.position_m:
        message = f"inside the capture tube of {exact(spec.capture.position_m)} m no time counts, and the corridor ends there"
        yield Wrong(message, "accepted: a length_m above capture.position_m, or none", ("corridor",))


def _bodies(problem: Problem) -> Iterator[Wrong]:
    """Collisions need two hulls."""
    hulls = {"target": problem.spec.target.hull, "pursuer": problem.spec.pursuer.hull}
    missing = [body for body, hull in hulls.items() if hull is None]
    if len(missing) == 1:
        (given,) = hulls.keys() - missing
        yield Wrong(f"there is no {missing[0]}.hull", f"accepted: {missing[0]}.hull too", (given, "hull"))


def _classes(problem: Problem) -> Iterator[Wrong]:
    """Conditions of requirements that no draw meets."""
    laws = {name: variable.law for variable in problem.dispersions.variables.values() for name in variable.draws}
    spans = {name: (-law.radius, law.radius) if hasattr(law, "radius") else (law.low, law.high) for name, law in laws.items()}  # pyright: ignore
    for part in problem.faults:
        if part.schedule is not None and isinstance(part.parameters, FaultParameters):
            spans = {name: span for name, span in spans.items() if not covers(f"{part.prefix}.onset_s", name)}  # may be ∞
            spans[f"{part.prefix}.schedule.failing"] = (0.0, float(len(part.parameters.channels)))
    for index, requirement in enumerate(problem.spec.require):
        for name, condition in requirement.where.items():
            if name in spans and not _met(condition, *spans[name]):
                low, high = spans[name]
                message = f"no draw is {condition}, the draws are {exact(low)} to {exact(high)}"
                yield Wrong(message, "accepted: a condition that some draws meet", ("require", index, "where", name))


def _met(condition: Condition, low: float, high: float) -> bool:
    """Whether some number from low to high meets a condition."""
    least, most = low, high
    if condition.at_least is not None:
        least = max(least, condition.at_least)
    if condition.equals is not None:
        least, most = max(least, condition.equals), min(most, condition.equals)
    return least <= most and (condition.below is None or least < condition.below)
