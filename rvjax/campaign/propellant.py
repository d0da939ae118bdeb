"""The propellant of the pursuer, as a campaign says it, and which pursuers can be without it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign.fields import Model, scalar, vector
from rvjax.campaign.inertia import INSTEAD, MatrixInertia, PrincipalInertia, corners, sigmas
from rvjax.campaign.inertia_validity import about_centre, physical
from rvjax.campaign.plain_values import exact
from rvjax.campaign.problems import Problem, refuse
from rvjax.campaign.quantity import Quantity


class Propellant(Model):
    """What the actuators burn. mass_kg is a part of pursuer.mass_kg, which holds all the propellant at t = 0."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"mass_kg": 8, "specific_impulse_s": 220, "tank_m": [-0.1, 0, 0]},
        {"mass_kg": {"uniform": [4, 8]}, "specific_impulse_s": 220, "torque_arm_m": 0.5},
    )

    mass_kg: Quantity = scalar("kg", above=0.0, doc="propellant at t = 0, a part of pursuer.mass_kg")
    specific_impulse_s: Quantity = scalar("s", above=0.0, doc="specific impulse of the thrusters")
    tank_m: Quantity = vector("m", default=0.0, doc="place of the propellant, from the reference point, in the pursuer's frame")
    torque_arm_m: Quantity | None = scalar(
        "m", default=None, above=0.0, doc="arm of the thrusters of the torque channels; without it torques burn nothing"
    )


def check_propellant(inertia: PrincipalInertia | MatrixInertia, mass: Quantity, centre: Quantity, propellant: Propellant) -> None:
    """Refuse propellant that can be as heavy as the pursuer, or without which the inertia is not physical, in some draw.

    With Σ = ½ tr(J) I − J, about the reference point and with all propellant, the condition for an empty tank is

        Σ − m c cᵀ − κ (r − c)(r − c)ᵀ ≥ 0,   κ = m p/(m − p)

    and with some propellant it is easier. It is convex in Σ, c and r together, for given other numbers concave in m, and gets
    harder as p grows: the corners at the largest p and at both ends of m tell. Where the principal axes, c or r may point
    anywhere, the largest eigenvalue of the second and third term must not be above the least of Σ.
    """
    (lightest, heaviest), (_, most) = mass.supports[0], propellant.mass_kg.supports[0]
    if not most < lightest:
        message = f"the propellant can be {exact(most)} kg of a pursuer of {exact(lightest)} kg"
        refuse(Problem(message, "accepted: less than pursuer.mass_kg, which includes it, in every draw", ("mass_kg",)))
    tank = propellant.tank_m
    if inertia.REJECTS or not (tank.largest_norm or centre.largest_norm):
        return
    unbounded = [size for size in (heaviest, tank.largest_norm, centre.largest_norm) if not math.isfinite(size)]
    if unbounded:
        words = f"accepted: bounded distributions, {INSTEAD} (in inertia_kgm2)"
        refuse(Problem("mass, centre of mass or tank is unbounded", words, ("tank_m",)))
    ends = [(m, m * most / (m - most)) for m in sorted({lightest, heaviest})]
    wrong = _free(inertia, centre, tank, ends) if _turns(inertia, centre, tank) else _fixed(inertia, centre, tank, ends)
    if wrong:
        accepted = f"accepted: less propellant, a tank nearer to the centre of mass, {INSTEAD} (in inertia_kgm2)"
        refuse(Problem(f"with an empty tank {wrong}", accepted, ("tank_m",)))


def _turns(inertia: PrincipalInertia | MatrixInertia, centre: Quantity, tank: Quantity) -> bool:
    """Whether the principal axes, the centre of mass or the tank may point anywhere."""
    turned = isinstance(inertia, PrincipalInertia) and (inertia.axis is not None or inertia.attitude is not None)
    return turned or centre.joint is not None or tank.joint is not None


def _fixed(inertia: PrincipalInertia | MatrixInertia, centre: Quantity, tank: Quantity, ends: list[tuple[float, float]]) -> str:
    """What is wrong at a corner of the box of supports; empty if nothing is. ends: (m, κ)."""
    box = corners(*inertia.entries, centre, tank)
    c, d = box[6:9], box[9:12] - box[6:9]
    for m, kappa in ends:
        entries: Any = tuple(box[:6])
        dry = about_centre(about_centre(entries, m, (c[0], c[1], c[2])), kappa, (d[0], d[1], d[2]))
        wrong = np.flatnonzero(~physical(dry))
        if wrong.size:
            at = ", ".join(exact(float(x)) for x in box[9:12, wrong[0]])
            return f"the draw {at} of a pursuer of {exact(m)} kg leaves an unphysical inertia"
    return ""


def _free(inertia: PrincipalInertia | MatrixInertia, centre: Quantity, tank: Quantity, ends: list[tuple[float, float]]) -> str:
    """As `_fixed`, where something may point anywhere."""
    allowed = max(float(np.linalg.eigvalsh(sigmas(inertia)).min()), 0.0)
    reached = max(_largest(centre, tank, m, kappa) for m, kappa in ends)
    if reached <= allowed:
        return ""
    return f"m |c|^2 and the tank together reach {exact(reached)} kg·m², the body allows {exact(allowed)} kg·m²"


def _largest(centre: Quantity, tank: Quantity, m: float, kappa: float) -> float:
    """The largest eigenvalue of m c cᵀ + κ (r − c)(r − c)ᵀ over all draws, or a bound of it if c or r is a joint distribution."""
    if centre.joint is not None or tank.joint is not None:
        c, r = centre.largest_norm, tank.largest_norm
        return m * c * c + kappa * (r + c) * (r + c)
    box: NDArray[np.float64] = corners(centre, tank).T
    c, d = box[:, :3], box[:, 3:] - box[:, :3]
    both = m * c[:, :, None] * c[:, None, :] + kappa * d[:, :, None] * d[:, None, :]
    return float(np.linalg.eigvalsh(both).max())
