"""A resolved campaign: the functions that fly (structure), and the quantities that are drawn or fixed (numbers).

campaigns/x.yaml ─load→ Spec ─resolve→ Problem
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from rvjax.campaign import Model, Quantity, Source, Spec, parse, parse_with, validate
from rvjax.campaign.actuators import Thrusters
from rvjax.campaign.choice import Choice
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.distributions import Fixed
from rvjax.campaign.horizon import not_whole
from rvjax.campaign.nominal_body import NominalBody
from rvjax.campaign.plain_values import Place, describe
from rvjax.campaign.python_files import PythonFile, is_python_file
from rvjax.campaign.schedule import Schedule
from rvjax.campaign.short_choices import ALLOCATION
from rvjax.columns import CHANNELS, Column, metric_and_channel
from rvjax.components.controllers.interface import DiscreteController
from rvjax.components.faults.interface import FaultParameters
from rvjax.components.metrics.interface import Metric
from rvjax.components.navigation.interface import NavigationError
from rvjax.components.registry import FAMILY_OF, Component, component, members, standard_metrics
from rvjax.errors import CampaignError, Finding, UsageError
from rvjax.physics.thruster_allocation import ThrusterSystem, wrench
from rvjax.simulation import guidance_checks, jax_config, requirement_checks
from rvjax.simulation.chosen_metrics import with_chosen
from rvjax.simulation.closed_loop import Loop
from rvjax.simulation.dispersions import Dispersions, resolve
from rvjax.simulation.margin_checks import AvailableSignals, ControllerChoice, EffectChoice, controller_of
from rvjax.simulation.named_laws import with_laws
from rvjax.simulation.outline import Entry, Outline
from rvjax.simulation.temporal_margins import margins_metric
from rvjax.simulation.user_checks import own_quantities, unused
from rvjax.stats.other_laws import OtherLaw

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

    loop, metrics: the compiled functions. controller, guidance, faults, disturbances, navigation: the quantities of their
    functions. actuation, effects: those of the actuators and the effects. chosen: those of the metrics that the campaign chooses.
    margins: the numbers of the temporal margins. dispersions: how numbers are drawn. fingerprint: SHA-256 of all that determines
    the draws and the flights. structure: SHA-256 of all that determines the compiled program.
    laws: other laws that the campaign names; only of a problem that `load` gives.
    """

    spec: Spec
    loop: Loop
    metrics: tuple[Metric, ...]
    controller: Part
    guidance: Part
    faults: tuple[Part, ...]
    disturbances: tuple[Part, ...]
    navigation: tuple[Part, ...]
    actuation: tuple[Part, ...]
    effects: tuple[Part, ...]
    chosen: tuple[Part, ...]
    margins: tuple[float, ...]
    dispersions: Dispersions
    fingerprint: str
    structure: str
    laws: Mapping[str, OtherLaw] = field(default_factory=dict[str, OtherLaw])

    @property
    def parts(self) -> tuple[Part, ...]:
        """Every component with numbers."""
        flown = (self.controller, self.guidance, *self.faults, *self.disturbances, *self.navigation)
        return (*flown, *self.actuation, *self.effects, *self.chosen)

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
    problem = _with_laws(_problem(*parse(path, overrides)))
    for baseline in problem.baselines.values():  # what does not fit a baseline is a finding too
        _with_laws(baseline)
    return problem


def _with_laws(problem: Problem) -> Problem:
    return with_laws(problem, lambda source: _problem(*parse(source)))


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
    metrics: tuple[Metric, ...] = standard_metrics(outline.has)
    if any(isinstance(entry.raw["use"], PythonFile) for entry in outline.components):
        _configure(source)  # the code of a user may start JAX
    parameters: dict[Place, Model] = {}
    body = NominalBody.of_campaign(spec, source)
    for entry in outline.components:
        if entry.section == "faults" and not outline.actuators:
            continue  # the names of the actuators are unknown until these are right
        try:
            model, more = _parameters(entry, outline, body, source)
        except CampaignError as error:  # of a user's code
            model, more = None, [*error.findings]
        except UsageError as error:  # of an installed package
            model, more = None, [source.finding(entry.name_place, str(error), "accepted: a package that can be imported")]
        findings += more
        if model is not None:
            parameters[entry.place] = model
    metrics, more = with_chosen(metrics, outline, parameters, spec, source)
    findings += more
    available = _available_signals(outline, parameters) if outline.margins is not None else None
    findings += available.findings(outline.margins, source) if available is not None else []
    findings += _unknown_metrics(source, outline, [name for metric in metrics for name in metric.columns])
    if spec is None or findings:
        raise CampaignError(dict.fromkeys(findings))
    for choice in spec.components:
        if choice.path not in parameters:  # the default, which the file does not name
            parameters[choice.path] = component(FAMILY_OF[choice.section], choice.use).parameters()
    if available is None or not spec.margins:
        return _resolve(spec, parameters, metrics, ())
    margins = margins_metric(spec.margins, available.signals, spec.horizon.step_s)
    return _resolve(spec, parameters, (*metrics, margins.metric), margins.numbers)


def _resolve(spec: Spec, parameters: Mapping[Place, Model], metrics: tuple[Metric, ...], margins: tuple[float, ...]) -> Problem:
    sampler = component("samplers", spec.sampler.use)
    part: dict[Place, Part] = {}
    build: dict[Place, Any] = {}
    drawn: dict[str, Quantity] = {}
    for choice in spec.flying:
        model, member = parameters[choice.path], component(FAMILY_OF[choice.section], choice.use)
        build[choice.path] = member.build(model)
        schedule = model.schedule if isinstance(model, FaultParameters) else None
        quantities = {name: quantity for name, quantity in model.quantities().items() if not name.startswith("schedule.")}
        part[choice.path] = Part(choice.prefix, quantities, member.noisy, schedule, member, model, choice.path)
        drawn |= model.quantities(choice.prefix)
    unfit = [
        spec.source.finding((*choice.path, *wrong.place), wrong.message, wrong.accepted)
        for choice in spec.flying
        for wrong in component(FAMILY_OF[choice.section], choice.use).unfit(parameters[choice.path], spec)
    ]
    if unfit:
        raise CampaignError(unfit)
    if len(implicit := [choice for choice in spec.effects if build[choice.path].implicit]) > 1:
        accepted = f"accepted: one effect whose reaction depends on the acceleration, beside {implicit[0].name} none"
        found = f"{implicit[1].use} and {implicit[0].use} each need the acceleration that the other changes"
        raise CampaignError([spec.source.finding(implicit[1].path, found, accepted)])
    if wrong := [*guidance_checks.findings(spec, parameters[spec.guidance.path], build[spec.guidance.path])]:
        raise CampaignError(wrong)
    dispersions = resolve(spec, spec.quantities() | drawn, sampler.build(parameters[spec.sampler.path]))
    if wrong := requirement_checks.findings(spec, dispersions.columns):
        raise CampaignError(wrong)
    sampling = _sampling(spec, build[spec.controller.path])
    return Problem(
        spec=spec,
        loop=Loop(
            controller=build[spec.controller.path],
            saturation=component("saturations", spec.saturation.use).build(parameters[spec.saturation.path]),
            faults=tuple(build[choice.path] for choice in spec.faults),
            disturbances=tuple(build[choice.path] for choice in spec.disturbances),
            navigation=tuple(build[choice.path] for choice in spec.navigation),
            actuation=tuple(build[choice.path] for choice in spec.actuation),
            effects=tuple(build[choice.path] for choice in spec.effects),
            guidance=build[spec.guidance.path],
            sampling=sampling,
            gear=_gear(spec.actuators, parameters) if isinstance(spec.actuators, Thrusters) else None,
        ),
        metrics=metrics,
        controller=part[spec.controller.path],
        guidance=part[spec.guidance.path],
        faults=tuple(part[choice.path] for choice in spec.faults),
        disturbances=tuple(part[choice.path] for choice in spec.disturbances),
        navigation=tuple(part[choice.path] for choice in spec.navigation),
        actuation=tuple(part[choice.path] for choice in spec.actuation),
        effects=tuple(part[choice.path] for choice in spec.effects),
        chosen=tuple(part[choice.path] for choice in spec.metrics),
        margins=margins,
        dispersions=dispersions,
        fingerprint=spec.fingerprint(parameters),
        structure=spec.structure(parameters, (sampling, *(metric.every for metric in metrics))),
    )


def _sampling(spec: Spec, controller: Any) -> int:
    """Steps between two instants of the controller; 0: it is continuous. CampaignError where a discrete-time controller has no
    period, or one that is not a whole number of steps."""
    if not isinstance(controller, DiscreteController):
        return spec.horizon.control_steps
    place = (*spec.controller.path, "period_s")
    if controller.period_s is None:
        if spec.horizon.control_period_s is None:
            accepted = "accepted: period_s here, or horizon.control_period_s, a whole number of steps"
            raise CampaignError([spec.source.finding(place, "a discrete-time controller without a period", accepted)])
        return spec.horizon.control_steps
    if wrong := not_whole(controller.period_s, spec.horizon.step_s):
        raise CampaignError([spec.source.finding(place, wrong.message, wrong.accepted)])
    return round(controller.period_s / spec.horizon.step_s)


def _configure(source: Source) -> None:
    """Configures JAX for the campaign, as far as its precision is right."""
    precision = (source.value or {}).get("precision", "float64")
    jax_config.configure("float32" if precision == "float32" else "float64")


def _gear(thrusters: Thrusters, parameters: Mapping[Place, Model]) -> ThrusterSystem:
    """The allocation and the wrench of the nominal layout."""
    layout, choice = thrusters.geometry, thrusters.allocation
    allocation = component("allocations", choice.use).build(parameters[choice.path])
    return ThrusterSystem(allocation(layout), wrench(layout))


def _parameters(entry: Entry, outline: Outline, body: NominalBody, source: Source) -> tuple[Model | None, list[Finding]]:
    """The parameters of a component, or every finding about them."""
    section, place, raw, _ = entry
    known = members(FAMILY_OF[section])
    use = raw["use"]
    if is_python_file(use) and not isinstance(use, PythonFile):
        return None, []  # there is a finding about the file already
    if use not in known and not isinstance(use, PythonFile):
        what, flag = _OWN.get(section, ("", ""))
        yours = f"; or ./FILE.py with {what}, such as `rvjax init --{flag} FILE.py` writes" if what else ""
        return None, [source.finding(entry.name_place, f"{describe(use)} is not known here", did_you_mean(use, known) + yours)]
    values = {key: value for key, value in raw.items() if key not in ("use", "name")}
    actuators = outline.actuators if section == "faults" else CHANNELS
    member: Component[Any] | Metric = component(FAMILY_OF[section], use)
    if not isinstance(member, Component):
        where = f"campaign with {' and '.join(member.needs)}" if member.needs else "campaign"
        return None, [source.finding(entry.name_place, f"{use} is on in every {where}", "accepted: no entry for it")]
    form: type[Model] = member.parameters
    model, findings = validate(form, body.complete(form, values), place, source, actuators)
    if isinstance(model, FaultParameters):
        model = _on_channels(model)
    known_thrusters = place != ALLOCATION or outline.layout is not None
    if model is not None and isinstance(use, PythonFile) and known_thrusters:
        dead = unused(use, FAMILY_OF[section], member, model, outline.layout)
        findings += [_without_use(name, member, place, use, source) for name in dead]
    return model, findings


_OWN = {
    "controller": ("a controller", "controller"),
    "baselines": ("a controller", "controller"),
    "actuation": ("an actuator", "actuator"),
    "actuators.allocation": ("an allocation", "allocation"),
    "effects": ("an effect", "effect"),
    "faults": ("a fault", "fault"),
    "disturbances": ("a disturbance", "disturbance"),
    "navigation": ("a navigation error", "navigation"),
    "guidance": ("a guidance", "guidance"),
    "metrics": ("a metric", "metric"),
}
"""Section → what a user's file can hold for it, and the option of `rvjax init` that writes such a file."""


def _without_use(name: str, member: Component[Any], place: Place, file: PythonFile, source: Source) -> Finding:
    """A finding about a number that the code of a component does not use."""
    gains = member.parameters.model_fields.get("gains")
    below = ("gains", name) if gains is not None and name in getattr(gains.annotation, "model_fields", {}) else (name,)
    return source.finding((*place, *below), f"{file.file} does not use {name}", "accepted: a parameter that something depends on")


def _on_channels(model: FaultParameters) -> FaultParameters:
    """The fault on its channels only: on all others its onset is NEVER and its other quantities are 0."""

    def masked(name: str, quantity: Quantity) -> Quantity:
        idle = NEVER if name in ("onset_s", "duration_s", "period_s") else Fixed(0.0)
        parts = zip(quantity.components, quantity.parts, strict=True)
        return replace(quantity, parts=tuple(part if channel in model.channels else idle for channel, part in parts))

    quantities = model.quantities().items()
    return model.model_copy(update={name: masked(name, q) for name, q in quantities if q.shape in ("channels", "thrusters")})


def _available_signals(outline: Outline, parameters: Mapping[Place, Model]) -> AvailableSignals:
    """The signals of the flights of a campaign, as far as its controllers, effects and actuators are right."""
    choices: dict[Place, ControllerChoice] = {}
    effects: dict[str, EffectChoice | None] = dict.fromkeys(outline.effects)
    errors: dict[str, NavigationError | None] = dict.fromkeys(outline.navigation)
    for section, place, raw, _ in outline.components:
        if (model := parameters.get(place)) is None:
            continue
        if section in CONTROLLERS:
            choices[place] = controller_of(component("controllers", raw["use"]).build(model), model.quantities())
        elif section == "effects":
            effects[outline.effects[int(place[1])]] = component("effects", raw["use"]).build(model), own_quantities(model)
        elif section == "navigation":
            errors[outline.navigation[int(place[1])]] = component("navigation", raw["use"]).build(model)
    baselines = {
        name: choices[place]
        for name, place in ((name, ("baselines", index)) for index, name in enumerate(outline.baselines))
        if place in choices
    }
    thrusters = 0 if outline.actuators == CHANNELS else len(outline.actuators)
    return AvailableSignals.of(
        choices.get(("controller",)),
        baselines,
        effects,
        errors,
        thrusters if outline.actuators else None,
        outline.has("pursuer.propellant"),
        outline.guided,
    )


def _unknown_metrics(source: Source, outline: Outline, names: Sequence[str]) -> list[Finding]:
    """Findings about requirements and objectives on unknown metrics, or on a channel of a metric without channels."""
    findings: list[Finding] = []
    columns = [*names, *outline.margin_metrics]
    known = dict.fromkeys(metric_and_channel(name)[0] for name in columns)
    needs = {name: metric.needs for metric in standard_metrics(lambda place: True) for name in metric.columns}
    for place, raw in outline.metric_uses:
        if not isinstance(metric := raw.get("metric"), str):
            continue
        channels = [channel for name, channel in map(metric_and_channel, columns) if name == metric]
        if lacks := [need for need in needs.get(metric, ()) if not outline.has(need)]:
            accepted = f"accepted: {' and '.join(lacks)} in the campaign, or another metric"
            findings.append(source.finding((*place, "metric"), f"{metric} needs {' and '.join(needs[metric])}", accepted))
        elif metric not in known:
            findings.append(source.finding((*place, "metric"), f"{describe(metric)} is no metric", did_you_mean(metric, known)))
        elif "channel" in raw and "any" not in channels:
            findings.append(source.finding((*place, "channel"), f"{metric} has no channels", "accepted: none", key=True))
    return findings
