"""Scenes that no flight can pass, refused before the flight: hulls that meet where they must not, starts in the keep-out zone.

    docked    the hulls are apart at ρ = 0, σ = 0      in the draws of the first samples
    start     the hulls are apart at t = 0             in the draws of the first samples
    gate      the guidance goes round the target outside of the keep-out zone      in the draws of the first samples
    keep-out  no start lies inside the zone and outside of the approach cone, for every possible draw

The last is decided from the supports of the distributions (`rvjax.simulation.start_zone`). A drawn attitude turns the start
about the docking point by any angle: then its smallest distance from there decides.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Quantity, Spec
from rvjax.campaign.plain_values import Place
from rvjax.campaign.start import AnyStart, FramedStart
from rvjax.elementary import cos, tan
from rvjax.errors import Finding
from rvjax.physics.hulls import least_distance, pose
from rvjax.physics.vectors import Vector, rotate_back, rotation
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.draws import Draws
from rvjax.simulation.guidance_checks import gate_in_the_zone
from rvjax.simulation.problem import Problem
from rvjax.simulation.start_frames import lvlh_axes, port_axes
from rvjax.simulation.start_zone import Starts, Zone, forbidden

Values = NDArray[np.float64]

BAD = "a start can lie inside the keep-out zone and outside of the approach cone"

NO_CONE = 2.0
"""A cosine that no place reaches."""


def findings(problem: Problem) -> list[Finding]:
    """What no flight can pass."""
    target = problem.spec.target
    if target.hull is None and target.keep_out is None:
        return []
    _, drawn = Draws.of(problem, np.arange(min(problem.spec.samples, LANES), dtype=np.int64))
    gate = gate_in_the_zone(problem.spec, problem.guidance.parameters, drawn)
    return [*_hulls(problem, drawn), *gate, *_keep_out(problem, drawn)]


def _hulls(problem: Problem, drawn: Drawn) -> Iterator[Finding]:
    """Hulls that are not apart when docked, or at t = 0."""
    if not drawn.context.hulls:
        return
    at_start = _distance(problem, drawn, drawn.motion.rho, drawn.motion.sigma)
    for when, distance, other in (
        ("docked, at rho 0 and sigma 0,", docked_distance(problem, drawn), "a target.port_m farther out"),
        ("at the start", at_start, "a start farther away"),
    ):
        if met := int(np.sum(~(distance > 0.0))):
            message = f"the hulls overlap {when} in {met} of the first {len(distance)} samples, by up to {-distance.min():.3g} m"
            accepted = f"accepted: smaller hulls, which do not include the docking mechanism, or {other}"
            yield problem.spec.source.finding(("pursuer", "hull"), message, accepted)


def docked_distance(problem: Problem, drawn: Drawn) -> Values:
    """(samples,) lower bound of the distance of the hulls [m] at ρ = 0, σ = 0. For a campaign with both hulls."""
    return _distance(problem, drawn, drawn.motion.rho * 0.0, drawn.motion.sigma * 0.0)


def _distance(problem: Problem, drawn: Drawn, rho: Vector, sigma: Vector) -> Values:
    """(samples,) lower bound of the distance of the hulls [m]."""
    jax_config.configure(problem.spec.precision)
    target, pursuer = drawn.context.hulls  # pyright: ignore[reportAssignmentType]  # there are both
    r = rotation(sigma)
    centred = pursuer._replace(centre=pursuer.centre - drawn.plant.centre)
    now = pose(target, centred, rotate_back(r, rho) + drawn.plant.port, r)
    return np.asarray(least_distance(target, centred, now, now), dtype=np.float64)


def _keep_out(problem: Problem, drawn: Drawn) -> Iterator[Finding]:
    """A start that can lie inside the zone and outside of the cone."""
    spec, finding = problem.spec, problem.spec.source.finding
    target, place, position = spec.target, *_position(spec.start)
    if target.keep_out is None or not target.has_docking_axis:
        return
    radii = target.keep_out.radii_m
    given = {("target", "keep_out", "radii_m"): radii, ("target", "port_m"): target.port_m, place: position}
    if endless := [key for key, quantity in given.items() if not np.all(np.isfinite(np.array(quantity.supports)))]:
        yield finding(
            endless[0], f"there are draws of any size: {BAD}", "accepted: laws with bounds; a truncated_normal has bounds"
        )
        return
    most, lvlh = np.array([high for _, high in radii.supports]), _frame(spec.start) == "lvlh"
    if position.joint is not None or not _direction_is_fixed(spec):
        origin = "the target's centre of mass" if lvlh else "the docking point"
        least, needed = _least_norm(position), float(most.max()) + (0.0 if lvlh else target.port_m.largest_norm)
        if least < needed:
            message = f"the direction of the start in T is drawn, its distance from {origin} is {least:.4g} m or more: {BAD}"
            accepted = f"accepted: a box along axes that are not drawn, or a distance of {needed:.4g} m or more in every draw"
            yield finding(place, message, accepted)
        return
    bad = forbidden(_starts(position, target.port_m, _turn(spec, drawn), lvlh), _zone(spec, most, drawn))
    if bad is not None:
        where = ", ".join(f"{x:.4g}" for x in bad)
        message = f"{BAD}, such as [{where}] m from the target's centre of mass, in its frame"
        yield finding(place, message, "accepted: starts outside of the zone or inside the cone, in every draw")


def _position(start: AnyStart) -> tuple[Place, Quantity]:
    """Where the position of the start stands, and the position."""
    if isinstance(start, FramedStart):
        return ("start", "position_m"), start.position_m
    return ("start", "rho_m"), start.rho_m


def _frame(start: AnyStart) -> str:
    """The frame of the position; that of the pursuer in the other form."""
    return start.frame if isinstance(start, FramedStart) else "pursuer"


def _direction_is_fixed(spec: Spec) -> bool:
    """Whether the axes of the position are the same in T in every draw."""
    start, target = spec.start, spec.target
    if _frame(start) == "port":
        return _axis_is_fixed(spec)
    if _frame(start) == "lvlh":
        return all(quantity.is_fixed for quantity in (target.attitude_mrp, *target.orbit.quantities().values()))
    return (start.attitude_mrp if isinstance(start, FramedStart) else start.sigma).is_fixed


def _axis_is_fixed(spec: Spec) -> bool:
    """Whether the docking axis is the same in T in every draw."""
    port = np.array(spec.target.port_m.supports)
    along = np.sum(np.any(port != 0.0, axis=1)) == 1 and bool(np.all(port[:, 0] * port[:, 1] >= 0.0))
    return spec.target.port_axis is not None or spec.target.port_m.is_fixed or along


def _turn(spec: Spec, drawn: Drawn) -> Values:
    """(3, 3) from the axes of the position to T; the same in every draw."""
    frame = _frame(spec.start)
    axes = port_axes(drawn.context.axis) if frame == "port" else lvlh_axes(drawn.target) if frame == "lvlh" else None
    axes = rotation(drawn.motion.sigma) if axes is None else axes
    return np.array([[np.ravel(part)[0] for part in row.parts()] for row in (axes.a, axes.b, axes.c)]).T


def _least_norm(quantity: Quantity) -> float:
    """The smallest |X| that its law allows. Of a joint law it is that of the smallest numbers that it consumes."""
    if quantity.joint is not None:
        return float(np.linalg.norm(quantity.joint.ppf(np.zeros((1, quantity.joint.uniforms)))))
    return float(np.linalg.norm([max(low, -high, 0.0) for low, high in quantity.supports]))


def _starts(position: Quantity, port: Quantity, turn: Values, centred: bool) -> Starts:
    """The starts as a map of the drawn components of the position and of the docking point. centred: the position is that from
    the target's centre of mass, else from the docking point."""
    ends = np.array([position.supports, port.supports])
    (middle, port_0), (wide, port_wide) = ends.mean(axis=2), np.diff(ends, axis=2)[..., 0]
    drawn = np.concatenate([wide, port_wide]) > 0.0
    away, by_away, by_port = turn @ middle, turn * wide, np.diag(port_wide)
    place, rho = (away, away - port_0) if centred else (away + port_0, away)
    by_place = np.hstack([by_away, by_port * (0.0 if centred else 1.0)])
    by_rho = np.hstack([by_away, by_port * (-1.0 if centred else 0.0)])
    return Starts(place, rho, by_place[:, drawn], by_rho[:, drawn])


def _zone(spec: Spec, radii: Values, drawn: Drawn) -> Zone:
    """The zone with the largest semi-axes. Where the docking axis is drawn, no start is surely in the cone."""
    corridor = spec.corridor
    cosine = float(cos(corridor.half_angle_rad)) if _axis_is_fixed(spec) else NO_CONE
    apex = corridor.radius_m / float(tan(corridor.half_angle_rad))
    axis = np.array([np.ravel(part)[0] for part in drawn.context.axis.parts()])
    return Zone(radii, axis, cosine, apex, spec.capture.position_m)
