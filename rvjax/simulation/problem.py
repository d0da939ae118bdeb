"""A resolved campaign: the functions that fly (structure), and the quantities that are drawn or fixed (numbers).

campaigns/x.yaml ─load→ Spec ─resolve→ Problem
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from rvjax.campaign import Model, Quantity, Source, Spec, parse, parse_with, validate
from rvjax.campaign.actuators import Thrusters
from rvjax.campaign.choice import Choice
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.distributions import Fixed
from rvjax.campaign.nominal_body import NominalBody
from rvjax.campaign.plain_values import Place, describe
from rvjax.campaign.schedule import Schedule
from rvjax.columns import CHANNELS, Column, metric_and_channel
from rvjax.components.faults.interface import FaultParameters
from rvjax.components.metrics.interface import Metric
from rvjax.components.registry import FAMILY_OF, Component, component, members
from rvjax.errors import CampaignError, Finding
from rvjax.physics.saturation import SATURATIONS
from rvjax.physics.thruster_allocation import Allocation, ThrusterSystem, bounded_least_squares, pseudo_inverse, wrench
from rvjax.simulation import requirement_checks
from rvjax.simulation.closed_loop import Loop
from rvjax.simulation.dispersions import Dispersions, resolve
from rvjax.simulation.margin_checks import AvailableSignals, ControllerChoice, controller_of
from rvjax.simulation.outline import Entry, Outline
from rvjax.simulation.temporal_margins import margins_metric

NEVER = Fixed(1e30)
"""Onset [s] of a fault on a channel that it does not act on."""

CONTROLLERS = ("controller", "baselines")


@dataclass(frozen=True)
class Part:
    """The quantities of a component by field, and the prefix of their names in the draws.

    noisy: it also gets the key of a random stream. schedule: of a fault that acts on some of its channels only. component,
    parameters, place: where they come from.
    """

    prefix: str
    quantities: Mapping[str, Quantity]
    noisy: bool = False
    schedule: Schedule | None = None
    component: Component[Any] | None = None
    parameters: Model | None = None
    place: Place = ()


@dataclass(frozen=True)
class Problem:
    """A campaign, ready to draw and fly.

    loop, metrics: the compiled functions. controller, faults, disturbances, navigation: the quantities of their functions.
    margins: the numbers of the temporal margins. dispersions: how numbers are drawn. fingerprint: SHA-256 of all that determines
    the draws and the flights. structure: SHA-256 of all that determines the compiled program.
    """

    spec: Spec
    loop: Loop
    metrics: tuple[Metric, ...]
    controller: Part
    faults: tuple[Part, ...]
    disturbances: tuple[Part, ...]
    navigation: tuple[Part, ...]
    margins: tuple[float, ...]
    dispersions: Dispersions
    fingerprint: str
    structure: str

    @property
    def metric_columns(self) -> dict[str, Column]:
        """The columns `metric.<name>` of the samples table, by name of the metric."""
        return {name: column for metric in self.metrics for name, column in metric.columns.items()}

    @cached_property
    def baselines(self) -> Mapping[str, Problem]:
        """The problem with each baseline as the controller, by name. CampaignError with what does not fit a baseline."""
        return _baselines(self)

    def with_values(self, values: Mapping[str, float | str]) -> Problem:
        """The same problem with other values at some places of the campaign: what `load` gives with `place=value`.

        The campaign is checked again, but not read again. Errors: CampaignError with every finding.
        """
        return _problem(*parse_with(self.spec, values))


def load(path: str | Path | Source, overrides: Sequence[str] = ()) -> Problem:
    """The problem of a campaign file, or of a source that was read before. overrides: `place=value`, as in `--set`.

    Errors: CampaignError with every finding, each with file, line and column; also where the campaign does not fit one of its
    baseline controllers.
    """
    problem = _problem(*parse(path, overrides))
    _ = problem.baselines  # what does not fit a baseline is a finding too
    return problem


def baseline_overrides(choice: Choice) -> tuple[str, ...]:
    """Overrides that replace the controller under test by a baseline."""
    controller = {"use": choice.use, "name": choice.name, **choice.parameters}
    return f"controller={json.dumps(controller)}", "baselines=[]"


def _baselines(problem: Problem) -> dict[str, Problem]:
    """`Problem.baselines`."""
    source, findings, found = problem.spec.source, list[Finding](), dict[str, Problem]()
    for index, choice in enumerate(problem.spec.baselines):
        try:
            found[choice.name] = _problem(*parse(source, baseline_overrides(choice)))
        except CampaignError as error:
            here = source.where(("baselines", index))
            findings += [
                replace(
                    finding,
                    where=here if finding.where.startswith("--set controller=") else finding.where,
                    found=f"with the baseline {choice.name}: {finding.found}",
                )
                for finding in error.findings
            ]
    if findings:
        raise CampaignError(findings)
    return found


def _problem(spec: Spec | None, findings: list[Finding], source: Source) -> Problem:
    """The problem of a campaign, from the results of `parse`. CampaignError with every finding."""
    outline = Outline.of(source)
    metrics: tuple[Metric, ...] = tuple(component("metrics", name) for name in members("metrics"))
    parameters: dict[Place, Model] = {}
    body = NominalBody.of_campaign(spec, source)
    for entry in outline.components:
        if entry.section == "faults" and not outline.actuators:
            continue  # the names of the actuators are unknown until these are right
        model, more = _parameters(entry, outline, body, source)
        findings += more
        if model is not None:
            parameters[entry.place] = model
    available = _available_signals(outline, parameters) if outline.margins is not None else None
    findings += available.findings(outline.margins, source) if available is not None else []
    findings += _unknown_metrics(source, outline, [name for metric in metrics for name in metric.columns])
    if spec is None or findings:
        raise CampaignError(dict.fromkeys(findings))
    if spec.sampler.path not in parameters:  # the default, which the file does not name
        parameters[spec.sampler.path] = component("samplers", spec.sampler.use).parameters()
    if available is None or not spec.margins:
        return _resolve(spec, parameters, metrics, ())
    margins = margins_metric(spec.margins, available.signals, spec.horizon.step_s)
    return _resolve(spec, parameters, (*metrics, margins.metric), margins.numbers)


def _resolve(spec: Spec, parameters: Mapping[Place, Model], metrics: tuple[Metric, ...], margins: tuple[float, ...]) -> Problem:
    sampler = component("samplers", spec.sampler.use)
    part: dict[Place, Part] = {}
    build: dict[Place, Any] = {}
    drawn: dict[str, Quantity] = {}
    for choice in (spec.controller, *spec.faults, *spec.disturbances, *spec.navigation):
        model, member = parameters[choice.path], component(FAMILY_OF[str(choice.path[0])], choice.use)
        build[choice.path] = member.build(model)
        schedule = model.schedule if isinstance(model, FaultParameters) else None
        quantities = {name: quantity for name, quantity in model.quantities().items() if not name.startswith("schedule.")}
        part[choice.path] = Part(choice.prefix, quantities, member.noisy, schedule, member, model, choice.path)
        drawn |= model.quantities(choice.prefix)
    dispersions = resolve(spec, spec.quantities() | drawn, sampler.build(parameters[spec.sampler.path]))
    if wrong := requirement_checks.findings(spec, dispersions.columns):
        raise CampaignError(wrong)
    return Problem(
        spec=spec,
        loop=Loop(
            controller=build[spec.controller.path],
            saturation=SATURATIONS[spec.saturation.use],
            faults=tuple(build[choice.path] for choice in spec.faults),
            disturbances=tuple(build[choice.path] for choice in spec.disturbances),
            navigation=tuple(build[choice.path] for choice in spec.navigation),
            sampling=spec.horizon.control_steps,
            gear=_gear(spec.actuators) if isinstance(spec.actuators, Thrusters) else None,
        ),
        metrics=metrics,
        controller=part[spec.controller.path],
        faults=tuple(part[choice.path] for choice in spec.faults),
        disturbances=tuple(part[choice.path] for choice in spec.disturbances),
        navigation=tuple(part[choice.path] for choice in spec.navigation),
        margins=margins,
        dispersions=dispersions,
        fingerprint=spec.fingerprint(parameters),
        structure=spec.structure(parameters),
    )


def _gear(thrusters: Thrusters) -> ThrusterSystem:
    """The allocation and the wrench of the nominal layout."""
    layout = thrusters.geometry
    allocations: Mapping[str, Callable[[], Allocation]] = {
        "bounded-least-squares": lambda: bounded_least_squares(layout),
        "pseudo-inverse": lambda: pseudo_inverse(layout, thrusters.centre),
    }
    return ThrusterSystem(allocations[thrusters.allocation](), wrench(layout))


def _parameters(entry: Entry, outline: Outline, body: NominalBody, source: Source) -> tuple[Model | None, list[Finding]]:
    """The parameters of a component, or every finding about them."""
    section, place, raw = entry
    known = SATURATIONS if section == "saturation" else members(FAMILY_OF[section])
    use = raw["use"]
    if use not in known:
        return None, [source.finding((*place, "use"), f"{describe(use)} is not known here", did_you_mean(use, known))]
    values = {key: value for key, value in raw.items() if key not in ("use", "name")}
    if section == "saturation":
        return validate(Model, values, place, source)
    actuators = outline.actuators if section == "faults" else CHANNELS
    form = component(FAMILY_OF[section], use).parameters
    model, findings = validate(form, body.complete(form, values), place, source, actuators)
    if isinstance(model, FaultParameters):
        model = _on_channels(model)
    return model, findings


def _on_channels(model: FaultParameters) -> FaultParameters:
    """The fault on its channels only: on all others its onset is NEVER and its other quantities are 0."""

    def masked(name: str, quantity: Quantity) -> Quantity:
        idle = NEVER if name in ("onset_s", "duration_s", "period_s") else Fixed(0.0)
        parts = zip(quantity.components, quantity.parts, strict=True)
        return replace(quantity, parts=tuple(part if channel in model.channels else idle for channel, part in parts))

    quantities = model.quantities().items()
    return model.model_copy(update={name: masked(name, q) for name, q in quantities if q.shape in ("channels", "thrusters")})


def _available_signals(outline: Outline, parameters: Mapping[Place, Model]) -> AvailableSignals:
    """The signals of the flights of a campaign, as far as its controllers and actuators are right."""
    choices: dict[Place, ControllerChoice] = {}
    for section, place, raw in outline.components:
        if section in CONTROLLERS and (model := parameters.get(place)) is not None:
            choices[place] = controller_of(component("controllers", raw["use"]).build(model), model.quantities())
    baselines = {
        name: choices[place]
        for name, place in ((name, ("baselines", index)) for index, name in enumerate(outline.baselines))
        if place in choices
    }
    thrusters = 0 if outline.actuators == CHANNELS else len(outline.actuators)
    return AvailableSignals.of(
        choices.get(("controller",)), baselines, outline.navigation, thrusters if outline.actuators else None
    )


def _unknown_metrics(source: Source, outline: Outline, names: Sequence[str]) -> list[Finding]:
    """Findings about requirements and objectives on unknown metrics, or on a channel of a metric without channels."""
    findings: list[Finding] = []
    columns = [*names, *outline.margin_metrics]
    known = dict.fromkeys(metric_and_channel(name)[0] for name in columns)
    for place, raw in outline.metric_uses:
        if not isinstance(metric := raw.get("metric"), str):
            continue
        channels = [channel for name, channel in map(metric_and_channel, columns) if name == metric]
        if metric not in known:
            findings.append(source.finding((*place, "metric"), f"{describe(metric)} is no metric", did_you_mean(metric, known)))
        elif "channel" in raw and "any" not in channels:
            findings.append(source.finding((*place, "channel"), f"{metric} has no channels", "accepted: none", key=True))
    return findings
