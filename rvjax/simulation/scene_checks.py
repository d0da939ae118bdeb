"""Scenes that no flight can pass, refused before the flight: hulls that meet where they must not, starts in the keep-out zone.

    docked    the hulls are apart at ρ = 0, σ = 0      in the draws of the first samples
    start     the hulls are apart at t = 0             in the draws of the first samples
    keep-out  no start lies inside the zone and outside of the approach cone, for every possible draw

The last is decided from the supports of the distributions (`rvjax.simulation.start_zone`). A drawn attitude turns the start
about the docking point by any angle: then its smallest distance from there decides.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Quantity, Spec
from rvjax.components.effect import has
from rvjax.elementary import cos, tan
from rvjax.errors import Finding
from rvjax.physics.hulls import least_distance, pose
from rvjax.physics.vectors import Vector, rotate_back, rotation
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem
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
    return [*_hulls(problem, drawn), *_keep_out(problem, drawn)]


def _hulls(problem: Problem, drawn: Drawn) -> Iterator[Finding]:
    """Hulls that are not apart when docked, or at t = 0."""
    if not drawn.context.hulls:
        return
    jax_config.configure(problem.spec.precision)
    rho, sigma = drawn.motion.rho, drawn.motion.sigma
    for when, distance, other in (
        ("docked, at rho 0 and sigma 0,", _distance(drawn, rho * 0.0, sigma * 0.0), "a target.port_m farther out"),
        ("at the start", _distance(drawn, rho, sigma), "a start farther away"),
    ):
        if met := int(np.sum(~(distance > 0.0))):
            message = f"the hulls overlap {when} in {met} of the first {len(distance)} samples, by up to {-distance.min():.3g} m"
            accepted = f"accepted: smaller hulls, which do not include the docking mechanism, or {other}"
            yield problem.spec.source.finding(("pursuer", "hull"), message, accepted)


def _distance(drawn: Drawn, rho: Vector, sigma: Vector) -> Values:
    """(samples,) lower bound of the distance of the hulls [m]."""
    target, pursuer = drawn.context.hulls  # pyright: ignore[reportAssignmentType]  # there are both
    r = rotation(sigma)
    centred = pursuer._replace(centre=pursuer.centre - drawn.plant.centre)
    now = pose(target, centred, rotate_back(r, rho) + drawn.plant.port, r)
    return np.asarray(least_distance(target, centred, now, now), dtype=np.float64)


def _keep_out(problem: Problem, drawn: Drawn) -> Iterator[Finding]:
    """A start that can lie inside the zone and outside of the cone."""
    spec, finding = problem.spec, problem.spec.source.finding
    target, start = spec.target, spec.start
    if target.keep_out is None or has(target.port_m, 0.0):
        return
    radii = target.keep_out.radii_m
    given = {("target", "keep_out", "radii_m"): radii, ("target", "port_m"): target.port_m, ("start", "rho_m"): start.rho_m}
    if endless := [place for place, quantity in given.items() if not np.all(np.isfinite(np.array(quantity.supports)))]:
        yield finding(
            endless[0], f"there are draws of any size: {BAD}", "accepted: laws with bounds; a truncated_normal has bounds"
        )
        return
    most = np.array([high for _, high in radii.supports])
    if start.rho_m.joint is not None or not start.sigma.is_fixed:
        least, needed = _least_norm(start.rho_m), float(most.max()) + target.port_m.largest_norm
        if least < needed:
            message = f"the direction of the start is drawn, its distance from the docking point is {least:.4g} m or more: {BAD}"
            accepted = f"accepted: a box of rho_m and a fixed sigma, or a distance of {needed:.4g} m or more in every draw"
            yield finding(("start", "rho_m"), message, accepted)
        return
    place = forbidden(_starts(start.rho_m, target.port_m, _turn(drawn)), _zone(spec, most))
    if place is not None:
        where = ", ".join(f"{x:.4g}" for x in place)
        message = f"{BAD}, such as [{where}] m from the target's centre of mass, in its frame"
        yield finding(("start", "rho_m"), message, "accepted: starts outside of the zone or inside the cone, in every draw")


def _turn(drawn: Drawn) -> Values:
    """(3, 3) Rᵀ of the start, which is the same in every draw."""
    r = rotation(drawn.motion.sigma)
    return np.array([[part[0] for part in row.parts()] for row in (r.a, r.b, r.c)]).T


def _least_norm(quantity: Quantity) -> float:
    """The smallest |X| that its law allows. Of a joint law it is that of the smallest numbers that it consumes."""
    if quantity.joint is not None:
        return float(np.linalg.norm(quantity.joint.ppf(np.zeros((1, quantity.joint.uniforms)))))
    return float(np.linalg.norm([max(low, -high, 0.0) for low, high in quantity.supports]))


def _starts(rho: Quantity, port: Quantity, turn: Values) -> Starts:
    """The starts as a map of the drawn components of ρ and of the docking point."""
    ends = np.array([rho.supports, port.supports])
    (rho_0, port_0), (rho_wide, port_wide) = ends.mean(axis=2), np.diff(ends, axis=2)[..., 0]
    drawn = np.concatenate([rho_wide, port_wide]) > 0.0
    by_rho, by_port, still = turn * rho_wide, np.diag(port_wide), np.zeros((3, 3))
    away = turn @ rho_0
    return Starts(away + port_0, away, np.hstack([by_rho, by_port])[:, drawn], np.hstack([by_rho, still])[:, drawn])


def _zone(spec: Spec, radii: Values) -> Zone:
    """The zone with the largest semi-axes. Where the direction of the docking axis is drawn, no start is surely in the cone."""
    corridor, port = spec.corridor, np.array(spec.target.port_m.supports)
    middle = port.mean(axis=1)
    certain = spec.target.port_m.is_fixed or (np.sum(np.any(port != 0.0, axis=1)) == 1 and np.all(port[:, 0] * port[:, 1] >= 0.0))
    cosine = float(cos(corridor.half_angle_rad)) if certain else NO_CONE
    apex = corridor.radius_m / float(tan(corridor.half_angle_rad))
    return Zone(radii, middle / (np.linalg.norm(middle) or 1.0), cosine, apex, spec.capture.position_m)
