"""Warnings about a campaign that can fly but hardly as meant: a law that does not fit its plant, numbers in another unit.

    guess        a given guess of mass or inertia is more than TWICE, or less than half, of the nominal body
    estimate     the bounds of an estimate exclude drawn values of the true parameter, in the first samples of the campaign
    disturbance  a drawn disturbance is above the ceiling of its estimated bound, or above the limit of the actuators
    braking      the approach brakes with (3√3/16) k₁ v_max, more than BRAKING times what the actuators give the nominal mass
    guidance     the reference point speeds up by more than the actuators give the nominal mass, never flies the speed that it is
                 given, or ends at a waypoint from which no sample is captured
    hulls        docked, at ρ = 0 and σ = 0, the hulls are apart by less than capture.position_m, in the draws of the first
                 samples: a pursuer inside the capture tube can touch the target
    density      m₀/(4/3 π R³), of the ball with the nominal mass and inertia (R² = 5/2 J₀/m₀), is outside of DENSITIES
    thrusters    the farthest thruster is more than FAR radii R from the reference point, or nearer than R/FAR

On v = k₁ρ/√(1+(k₁ρ/v_max)²) the deceleration v dv/dρ is largest at k₁ρ = v_max/√3, where it is (3√3/16) k₁ v_max.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from typing import Any

import numpy as np

from rvjax.campaign import Model, Quantity, Spec
from rvjax.campaign.actuators import Thrusters
from rvjax.campaign.choice import Choice
from rvjax.campaign.declarations import declared
from rvjax.campaign.nominal_body import NominalBody
from rvjax.campaign.plain_values import Place, exact, is_mapping
from rvjax.campaign.reference_body import UNITS
from rvjax.components.guidance.interface import GuidanceParameters
from rvjax.components.guidance.waypoints import Parameters as Waypoints
from rvjax.components.registry import component
from rvjax.errors import Finding
from rvjax.simulation.batch import LANES
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem
from rvjax.simulation.scene_checks import docked_distance

TWICE = 2.0
BRAKING = 5.0
FAR = 10.0
DENSITIES = (0.01, 22_600.0)
"""kg/m³: a solar sail with its booms as a ball, and osmium."""

STEADY = ("constant", "sinusoid")
"""Disturbances whose force_N and torque_Nm last."""


def warnings(problem: Problem) -> tuple[Finding, ...]:
    """What is hardly meant in a campaign, in the order of the file."""
    spec = problem.spec
    body = NominalBody.of(spec.pursuer)
    _, drawn = Draws.of(problem, np.arange(min(spec.samples, LANES), dtype=np.int64))
    found = [*_density(spec, body), *_thrusters(spec, body), *_disturbances(spec, drawn)]
    found += [*_guidance(problem, body), *_hulls(problem, drawn)]
    for choice in (spec.controller, *spec.baselines):
        form = component("controllers", choice.use).parameters
        model = form.model_validate(body.complete(form, choice.parameters))
        gains = {name.removeprefix("gains."): quantity for name, quantity in model.quantities().items()}
        found += _guesses(spec, choice, model, body)
        found += _estimates(spec, choice, gains, drawn) if getattr(model, "adapt_parameters", True) else ()
        found += _ceilings(spec, choice, gains, drawn) if getattr(model, "adapt_bound", True) else ()
        found += _braking(spec, choice, gains, body)
    return tuple(sorted(dict.fromkeys(found), key=lambda finding: finding.order))


def _guesses(spec: Spec, choice: Choice, model: Model, body: NominalBody) -> Iterator[Finding]:
    given = choice.parameters.get("gains")
    gains = getattr(model, "gains", model)
    for key, info in type(gains).keys().items():
        about = declared(info)
        if about is None or about.follows is None or "guess" not in key or not is_mapping(given) or key not in given:
            continue
        nominal, (value,) = getattr(body, about.follows), getattr(gains, key).medians
        if nominal / TWICE <= value <= nominal * TWICE:
            continue
        unit = UNITS[about.follows]
        message = f"the guess is {value:g} {unit}, {value / nominal:.3g} times the nominal {about.follows} of the pursuer"
        right = f"right would be about {nominal:g} {unit}, which is the default"
        yield spec.source.finding((*choice.path, "gains", key), message, right)


ESTIMATED = (
    ("mass", "kg", "mass_min_kg", "mass_max_kg", lambda plant: (plant.mass,)),
    ("moments of inertia", "kg·m²", "moment_min_kgm2", "moment_max_kgm2", lambda plant: plant.inertia.parts()[:3]),
    ("products of inertia", "kg·m²", "", "product_max_kgm2", lambda plant: plant.inertia.parts()[3:]),
)
"""What a controller estimates: name, unit, names of its bounds, true values. Without a lower bound it is minus the upper one."""


def _estimates(spec: Spec, choice: Choice, gains: Mapping[str, Quantity], drawn: Drawn) -> Iterator[Finding]:
    for what, unit, low, high, true in ESTIMATED:
        if high not in gains:
            continue
        ceiling = gains[high].medians[0]
        floor = gains[low].medians[0] if low else -ceiling
        values = np.array(true(drawn.plant))
        outside = int(np.any((values < floor) | (values > ceiling), axis=0).sum())
        if not outside:
            continue
        least, most = float(values.min()), float(values.max())
        message = (
            f"the estimate stays from {floor:g} to {ceiling:g} {unit}, but the {what} of {outside} of the first "
            f"{values.shape[1]} samples are outside: from {least:.4g} to {most:.4g} {unit}"
        )
        right = {low: f"{low} of at most {_at_most(least)}"} if low and least < floor else {}
        if most > ceiling or (not low and least < floor):
            right[high] = f"{high} of at least {_at_least(max(most, most if low else -least))}"
        yield spec.source.finding(
            (*choice.path, "gains", next(iter(right))), message, f"right would be {' and '.join(right.values())}"
        )


def _wrench(numbers: Any) -> np.ndarray[Any, Any]:
    """(6, samples) magnitudes of a steady disturbance."""
    return np.abs(np.array([*numbers.force_N.parts(), *numbers.torque_Nm.parts()]))


def _steady(spec: Spec, drawn: Drawn) -> Iterator[tuple[Choice, np.ndarray[Any, Any]]]:
    for choice, numbers in zip(spec.disturbances, drawn.disturbances, strict=True):
        if choice.use in STEADY:
            yield choice, _wrench(numbers)


HALVES = (("force", "N", "force_N", slice(0, 3)), ("torque", "N·m", "torque_Nm", slice(3, 6)))


def _disturbances(spec: Spec, drawn: Drawn) -> Iterator[Finding]:
    limits = np.minimum(np.array(drawn.upper.parts()), np.array(drawn.lower.parts()))
    for choice, size in _steady(spec, drawn):
        for half, unit, key, rows in HALVES:
            beaten = int(np.any(size[rows] > limits[rows], axis=0).sum())
            if beaten:
                message = (
                    f"the {half} reaches {size[rows].max():.4g} {unit} on an axis, in {beaten} of the first "
                    f"{size.shape[1]} samples more than the actuators can give"
                )
                right = f"right would be at most {_at_most(float(limits[rows].min()))} {unit}, or stronger actuators"
                yield spec.source.finding((*choice.path, key), message, right)


def _ceilings(spec: Spec, choice: Choice, gains: Mapping[str, Quantity], drawn: Drawn) -> Iterator[Finding]:
    if "bound_share" not in gains:
        return
    share = gains["bound_share"].medians[0]
    limits = 0.5 * (np.array(drawn.upper.parts()) + np.array(drawn.lower.parts()))
    for other, size in _steady(spec, drawn):
        for half, unit, _, rows in HALVES:
            above = int(np.any(size[rows] > share * limits[rows], axis=0).sum())
            if above:
                message = (
                    f"the estimated bound of the {half} ends at {share * limits[rows].min():.4g} {unit}, but "
                    f"{other.name} is above it in {above} of the first {size.shape[1]} samples: "
                    f"up to {size[rows].max():.4g} {unit}"
                )
                right = f"right would be a bound_share of at least {_at_least(float((size[rows] / limits[rows]).max()))}"
                yield spec.source.finding((*choice.path, "gains", "bound_share"), message, right)


def _braking(spec: Spec, choice: Choice, gains: Mapping[str, Quantity], body: NominalBody) -> Iterator[Finding]:
    if not {"k1", "v_max_m_s"} <= gains.keys():
        return
    k1, speed = gains["k1"].medians[0], gains["v_max_m_s"].medians[0]
    wanted, (force, able) = 3.0 * math.sqrt(3.0) / 16.0 * k1 * speed, _able(spec, body)
    if wanted > BRAKING * able:
        message = (
            f"the approach brakes with up to {wanted:.3g} m/s², but {force:.4g} N give {body.mass:g} kg only {able:.3g} m/s²: "
            "it arrives too fast to stop"
        )
        most = _at_most(able * 16.0 / (3.0 * math.sqrt(3.0)))
        right = f"right would be k1 times v_max_m_s of at most {most} m/s², or stronger actuators"
        yield spec.source.finding((*choice.path, "gains", "k1"), message, right)


def _able(spec: Spec, body: NominalBody) -> tuple[float, float]:
    """The smallest limit of the forces [N], and what it gives the nominal mass [m/s²]."""
    force = min(*spec.actuators.upper.medians[:3], *spec.actuators.lower.medians[:3])
    return force, force / body.mass


def _guidance(problem: Problem, body: NominalBody) -> Iterator[Finding]:
    spec, model = problem.spec, problem.guidance.parameters
    if not isinstance(model, GuidanceParameters):
        return
    place, (force, able) = spec.guidance.path, _able(spec, body)
    (accel,), (follows,) = model.acceleration.medians, model.time_constant_s.medians
    if accel > able:
        message = (
            f"the reference point speeds up with {accel:.3g} m/s², but {force:.4g} N give {body.mass:g} kg only {able:.3g} m/s²"
        )
        yield spec.source.finding((*place, "acceleration"), message, f"right would be at most {_at_most(able)} m/s²")
    slope = model.quantities().get("slope")
    steep = min(slope.medians[0], 0.25 / follows) if slope is not None else 0.0
    for at, speed in _speeds(model):
        if speed * steep > accel * (1.0 + 1e-9):
            message = f"the reference point flies {accel / steep:.3g} m/s at most: from {speed:g} m/s it could not brake in time"
            right = f"right would be {_at_most(accel / steep)} m/s, a smaller slope or a larger acceleration"
            yield spec.source.finding((*place, *at), message, right)
    if isinstance(model, Waypoints):
        last, away = model.points[-1], math.hypot(*model.points[-1].at_m)
        if last.frame == "lvlh" or away > spec.capture.position_m:
            found = "fixed in LVLH" if last.frame == "lvlh" else f"{away:g} m from the docking point"
            message = f"the last waypoint is {found}: no sample is captured"
            right = "right would be {frame: port, at_m: [0, 0, 0], …}, unless holding is what is studied"
            yield spec.source.finding((*place, "points", len(model.points) - 1), message, right)


def _hulls(problem: Problem, drawn: Drawn) -> Iterator[Finding]:
    spec = problem.spec
    if not drawn.context.hulls:
        return
    distance, tube = np.round(docked_distance(problem, drawn), 9), spec.capture.position_m
    if near := int(np.count_nonzero((distance > 0.0) & (distance < tube))):  # hulls that overlap are refused
        message = (
            f"docked, at rho 0 and sigma 0, the hulls are {distance.min():.3g} m apart, nearer than the capture radius of "
            f"{exact(tube)} m, in {near} of the first {len(distance)} samples: a captured pursuer can touch the target"
        )
        right = f"right would be at most {_at_most(float(distance.min()))} m, smaller hulls, or a target.port_m farther out"
        yield spec.source.finding(("capture", "position_m"), message, right)


def _speeds(model: GuidanceParameters) -> Iterator[tuple[Place, float]]:
    """The largest speeds of a reference point, each with its place."""
    if isinstance(model, Waypoints):
        yield from ((("points", index, "speed_m_s"), point.speed_m_s) for index, point in enumerate(model.points))
    for name in ("far_speed_m_s", "speed_m_s"):
        if (quantity := model.quantities().get(name)) is not None:
            yield (name,), quantity.medians[0]


def _at_most(value: float) -> str:
    """The value to three digits, rounded down, so that a number which follows the advice is not warned of again."""
    return _to_three_digits(value, ROUND_FLOOR)


def _at_least(value: float) -> str:
    """The value to three digits, rounded up."""
    return _to_three_digits(value, ROUND_CEILING)


def _to_three_digits(value: float, way: str) -> str:
    number = Decimal(repr(value))  # 0.6, not 0.59999999999999997780
    return exact(float(number.quantize(Decimal(1).scaleb(number.adjusted() - 2), rounding=way)))


def _radius(body: NominalBody) -> float:
    """R [m] of the ball with the same mass and inertia."""
    return math.sqrt(2.5 * body.inertia / body.mass)


def _density(spec: Spec, body: NominalBody) -> Iterator[Finding]:
    radius = _radius(body)
    density = body.mass / (4.0 / 3.0 * math.pi * radius**3) if radius > 0.0 else math.inf
    low, high = DENSITIES
    if not low <= density <= high:
        message = (
            f"{body.mass:g} kg with a mean moment of {body.inertia:.4g} kg·m² are as dense as a ball of {radius:.3g} m with "
            f"{density:.3g} kg/m³"
        )
        right = f"right would be {exact(low)} to {high:,.0f} kg/m³; masses are in kg, moments of inertia in kg·m²"
        yield spec.source.finding(("pursuer", "inertia_kgm2"), message, right)


def _thrusters(spec: Spec, body: NominalBody) -> Iterator[Finding]:
    if not isinstance(spec.actuators, Thrusters):
        return
    radius = _radius(body)
    farthest = max(math.hypot(*at) for at in spec.actuators.geometry.at)
    if not radius / FAR <= farthest <= radius * FAR:
        message = (
            f"the thrusters are up to {farthest:.3g} m from the reference point, but the inertia is that of a ball with a radius "
            f"of {radius:.3g} m"
        )
        right = f"right would be {radius / FAR:.3g} to {radius * FAR:.3g} m; places are in m"
        yield spec.source.finding(("actuators", "size_m" if spec.actuators.layout else "thrusters"), message, right)
