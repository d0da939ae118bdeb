"""A campaign resolved: which functions fly (structure), and which quantities are drawn or fixed (numbers).

campaigns/x.yaml ─load→ Spec ─resolve→ Problem
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rvjax.campaign import Model, Quantity, Source, Spec, parse, parse_with, validate
from rvjax.campaign.actuators import Thrusters, actuator_names
from rvjax.campaign.choice import entry_names
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.distributions import Fixed
from rvjax.campaign.plain_values import Place, describe, is_list, is_mapping
from rvjax.campaign.schedule import Schedule
from rvjax.columns import CHANNELS, MARGIN, Column, metric_and_channel
from rvjax.components.faults.interface import FaultParameters
from rvjax.components.metrics.interface import Metric
from rvjax.components.registry import FAMILY_OF, component, members
from rvjax.errors import CampaignError, Finding
from rvjax.physics.saturation import SATURATIONS
from rvjax.physics.thruster_allocation import Allocation, ThrusterSystem, bounded_least_squares, pseudo_inverse, wrench
from rvjax.simulation import requirement_checks
from rvjax.simulation.closed_loop import Loop
from rvjax.simulation.dispersions import Dispersions, resolve
from rvjax.simulation.margin_checks import AvailableSignals, ControllerChoice, controller_of
from rvjax.simulation.temporal_margins import folded

NEVER = Fixed(1e30)
"""Onset [s] of a fault on a channel that the campaign leaves out."""

CONTROLLERS = ("controller", "baselines")


@dataclass(frozen=True)
class Part:
    """The quantities of one component by field, and the prefix of their names in the draws.

    noisy: it also gets the key of a random stream. schedule: of a fault that befalls only some of its channels.
    """

    prefix: str
    quantities: Mapping[str, Quantity]
    noisy: bool = False
    schedule: Schedule | None = None


@dataclass(frozen=True)
class Problem:
    """loop, metrics: what is compiled. controller, faults, disturbances, navigation: the numbers that their functions get.

    margins: the numbers of the temporal margins. dispersions: how the numbers are drawn. fingerprint: SHA-256 of everything that
    decides the draws and the flights; structure: of everything that decides which program flies.
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
        """The columns `metric.<name>` of the samples table, by metric."""
        return {name: column for metric in self.metrics for name, column in metric.columns.items()}

    def with_values(self, values: Mapping[str, float | str]) -> Problem:
        """The same problem with other values at some places of the campaign: what `load` gives with `place=value`.

        The campaign is checked again, but not read again. Errors: CampaignError with every finding.
        """
        return _problem(*parse_with(self.spec, values))


def load(path: str | Path | Source, overrides: Sequence[str] = ()) -> Problem:
    """The problem that a campaign file states, or one that was read before. overrides: `place=value`, as in `--set`.

    Errors: CampaignError with every finding, each with file, line and column.
    """
    return _problem(*parse(path, overrides))


def _problem(spec: Spec | None, findings: list[Finding], source: Source) -> Problem:
    """The problem that a campaign states, as `parse` gives it. CampaignError with every finding."""
    metrics: tuple[Metric, ...] = tuple(component("metrics", name) for name in members("metrics"))
    parameters: dict[Place, Model] = {}
    names = actuator_names((source.value or {}).get("actuators"))
    for section, place, raw in _entries(source):
        if section == "faults" and not names:
            continue  # nobody knows what may fail before the actuators are right
        model, more = _parameters(section, place, raw, source, names if section == "faults" else CHANNELS)
        findings += more
        if model is not None:
            parameters[place] = model
    offered = _offered(source, parameters, names) if "margins" in (source.value or {}) else None
    findings += offered.wrong(source) if offered is not None else []
    findings += _unknown_metrics(source, [*(name for metric in metrics for name in metric.columns), *_margins(source)])
    if spec is None or findings:
        raise CampaignError(dict.fromkeys(findings))
    if spec.sampler.path not in parameters:  # nothing was said: the default
        parameters[spec.sampler.path] = component("samplers", spec.sampler.use).parameters()
    margins = folded(spec.margins, offered.signals, spec.horizon.step_s) if offered is not None and spec.margins else None
    return _resolve(
        spec, parameters, metrics if margins is None else (*metrics, margins.metric), margins.numbers if margins else ()
    )


def _resolve(spec: Spec, parameters: Mapping[Place, Model], metrics: tuple[Metric, ...], margins: tuple[float, ...]) -> Problem:
    sampler = component("samplers", spec.sampler.use)
    part: dict[Place, Part] = {}
    build: dict[Place, Any] = {}
    drawn: dict[str, Quantity] = {}
    for choice in (spec.controller, *spec.faults, *spec.disturbances, *spec.navigation):
        own, found = parameters[choice.path], component(FAMILY_OF[str(choice.path[0])], choice.use)
        build[choice.path] = found.build(own)
        schedule = own.schedule if isinstance(own, FaultParameters) else None
        quantities = {name: quantity for name, quantity in own.quantities().items() if not name.startswith("schedule.")}
        part[choice.path] = Part(choice.prefix, quantities, found.noisy, schedule)
        drawn |= own.quantities(choice.prefix)
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
    """Allocation by the nominal layout, and what its thrusts give."""
    layout = thrusters.geometry
    allocations: Mapping[str, Callable[[], Allocation]] = {
        "bounded-least-squares": lambda: bounded_least_squares(layout),
        "pseudo-inverse": lambda: pseudo_inverse(layout, thrusters.centre),
    }
    return ThrusterSystem(allocations[thrusters.allocation](), wrench(layout))


def _entries(source: Source) -> Iterator[tuple[str, Place, dict[str, Any]]]:
    """(section, place, what it says) of every component that a file names, whatever else is wrong with the file."""
    for section in (*FAMILY_OF, "saturation"):
        given = (source.value or {}).get(section)
        listed = enumerate(given) if is_list(given) else [(None, given)]
        for index, raw in listed:
            if is_mapping(raw) and isinstance(raw.get("use"), str):
                yield section, (section,) if index is None else (section, index), raw


def _parameters(
    section: str, place: Place, raw: dict[str, Any], source: Source, names: tuple[str, ...]
) -> tuple[Model | None, list[Finding]]:
    """The parameters of one component, or every finding about them. names: of the actuators that it is about."""
    known = SATURATIONS if section == "saturation" else members(FAMILY_OF[section])
    use = raw["use"]
    if use not in known:
        return None, [source.finding((*place, "use"), f"{describe(use)} is not known here", did_you_mean(use, known))]
    own = {key: value for key, value in raw.items() if key not in ("use", "name")}
    if section == "saturation":
        return validate(Model, own, place, source)
    model, findings = validate(component(FAMILY_OF[section], use).parameters, own, place, source, names)
    if isinstance(model, FaultParameters):
        model = _only(model)
        findings += _late_onsets(model, place, source)
    return model, findings


def _only(model: FaultParameters) -> FaultParameters:
    """The fault with its quantities on the channels that it leaves out fixed, and their onset never."""

    def masked(name: str, quantity: Quantity) -> Quantity:
        idle = NEVER if name in ("onset_s", "duration_s", "period_s") else Fixed(0.0)
        parts = zip(quantity.components, quantity.parts, strict=True)
        return replace(quantity, parts=tuple(part if channel in model.channels else idle for channel, part in parts))

    quantities = model.quantities().items()
    return model.model_copy(update={name: masked(name, q) for name, q in quantities if q.shape in ("channels", "thrusters")})


def _late_onsets(model: FaultParameters, place: Place, source: Source) -> list[Finding]:
    """A fault that cannot begin before the flight ends is a mistake."""
    horizon = (source.value or {}).get("horizon")
    duration = horizon.get("duration_s") if is_mapping(horizon) else None
    earliest = min(low for low, _ in model.onset_s.supports)
    if not isinstance(duration, (int, float)) or earliest < duration:
        return []
    found = f"the earliest onset of {earliest:g} s is not before the end of the flight"
    return [source.finding((*place, "onset_s"), found, f"accepted: an onset below {duration:g} s")]


def _offered(source: Source, parameters: Mapping[Place, Model], actuators: tuple[str, ...]) -> AvailableSignals:
    """The signals of the flights of a campaign, as far as it says of its controllers and actuators what is right."""
    said: Mapping[str, Any] = source.value or {}
    baselines = said.get("baselines")
    others = baselines if is_list(baselines) else []
    uses: dict[Place, str] = {place: raw["use"] for section, place, raw in _entries(source) if section in CONTROLLERS}
    laws: dict[Place, ControllerChoice] = {}
    for place, use in uses.items():
        if (own := parameters.get(place)) is not None:
            laws[place] = controller_of(component("controllers", use).build(own), own.quantities())
    named = zip(entry_names(others), (laws.get(("baselines", index)) for index in range(len(others))), strict=True)
    return AvailableSignals.of(
        laws.get(("controller",)),
        {name: law for name, law in named if law is not None},
        bool(said.get("navigation")),
        (0 if actuators == CHANNELS else len(actuators)) if actuators else None,
    )


def _margins(source: Source) -> list[str]:
    """The names of the metrics that the margins of a campaign become."""
    said = (source.value or {}).get("margins")
    return [f"{MARGIN}{name}" for name in said] if is_mapping(said) else []


def _unknown_metrics(source: Source, names: Sequence[str]) -> list[Finding]:
    """Requirements and objectives on metrics that no flight gives, or on a channel of a metric that has none."""
    findings: list[Finding] = []
    bare = dict.fromkeys(metric_and_channel(name)[0] for name in names)
    for place, raw in _of_metrics(source.value or {}):
        if not is_mapping(raw) or not isinstance(metric := raw.get("metric"), str):
            continue
        channels = [channel for name, channel in map(metric_and_channel, names) if name == metric]
        if metric not in bare:
            findings.append(source.finding((*place, "metric"), f"{describe(metric)} is no metric", did_you_mean(metric, bare)))
        elif "channel" in raw and "any" not in channels:
            findings.append(source.finding((*place, "channel"), f"{metric} has no channels", "accepted: none", key=True))
    return findings


def _of_metrics(campaign: Mapping[str, Any]) -> Iterator[tuple[Place, Any]]:
    """What a campaign says of metrics: its requirements, and the objectives of a tuning."""
    tuning = campaign.get("tune")
    for place, said in (
        (("require",), campaign.get("require")),
        (("tune", "objective"), is_mapping(tuning) and tuning.get("objective")),
    ):
        if is_mapping(said):
            yield place, said
        for index, raw in enumerate(said if is_list(said) else []):
            yield (*place, index), raw
