"""Through waypoints, one after the other, each given in the port's frame or in LVLH.

    u = c₁ d/|d| min(v', κ'|d|),   d = g − p,   in the frame of the waypoint: T, or LVLH

g: the waypoint, from the docking point. κ' = min(κ, 1/(4T)), v' = min(v, a/κ'): the point brakes with a at most. So it goes to
each waypoint on a straight line in the waypoint's frame, and stands still there. A waypoint is passed once the reference point
and the pursuer have been within `within_m` of it for `hold_s`; the last is held to the end. c₁: 1 for a pursuer up to lag_m from
the reference point, 0 from twice this distance on.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, ClassVar, Literal, NamedTuple

import jax
import jax.numpy as jnp
from pydantic import field_validator

from rvjax.campaign import Quantity, number, option, part, scalar
from rvjax.campaign.fields import Model
from rvjax.campaign.plain_values import Place
from rvjax.campaign.problems import Problem, refuse
from rvjax.campaign.triples import Triple
from rvjax.components.guidance.interface import (
    Guidance,
    GuidanceParameters,
    Need,
    Situation,
    Wanted,
    brakes,
    granted,
    in_target,
    length,
    limited,
)
from rvjax.components.registry import Component
from rvjax.physics.orbit_frame import Turning, orbit_axes, orbit_turning, port_axes
from rvjax.physics.state import Numbers, Path
from rvjax.physics.vectors import Scalar, Vector, rotate_back

MOST = 16


class Waypoint(Model):
    """A place, how fast to go there, and when to go on."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"frame": "port", "at_m": [0, 0, 0], "speed_m_s": 0.1},
        {"frame": "lvlh", "at_m": [-50, 0, 0], "speed_m_s": 0.3},
    )

    frame: Literal["port", "lvlh"] = option(doc="frame of the place")
    at_m: Triple = option(doc="port: from the docking point, first along the docking axis; lvlh: from the target's centre [m]")
    speed_m_s: float = number("m/s", above=0.0, doc="largest speed v on the way there")
    within_m: float = number("m", default=0.5, above=0.0, doc="radius within which the waypoint is reached")
    hold_s: float = number("s", default=0.0, at_least=0.0, doc="time that it is held")


class Parameters(GuidanceParameters):
    """The waypoints and the motion of the reference point."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"points": list(reversed(Waypoint.EXAMPLES))},)

    points: tuple[Waypoint, ...] = part(doc=f"waypoints in their order, {MOST} at most")
    slope: Quantity = scalar("1/s", default=0.05, above=0.0, doc="speed per distance κ")
    lag_m: Quantity = scalar("m", default=0.5, above=0.0, doc="distance of the pursuer from it up to which it goes on")

    @field_validator("points")
    @classmethod
    def _some(cls, points: tuple[Waypoint, ...]) -> tuple[Waypoint, ...]:
        if not 1 <= len(points) <= MOST:
            refuse(Problem(f"found {len(points)} waypoints", f"accepted: 1 to {MOST}"))
        return points


class Progress(NamedTuple):
    """number: of the present waypoint, from 0. since: when it was reached [s], +∞ before."""

    number: Scalar
    since: Scalar


def start(situation: Situation, path: Path, numbers: Numbers) -> Progress:
    """On the way to the first."""
    del path, numbers
    return Progress(situation.t * 0.0, situation.t * 0.0 + jnp.inf)


def wanted(points: tuple[Waypoint, ...], situation: Situation, path: Path, kept: Progress, numbers: Numbers) -> Wanted:
    """u in the frame of the present waypoint, and the progress."""
    goal, turning, (speed, within, hold) = _present(points, situation, kept.number)
    away, pursuer = goal - path.point, in_target(situation)
    slope, most = brakes(speed, numbers)
    u = limited(away * slope, most) * granted(pursuer - path.point, numbers.lag_m)
    arrived = (length(away) <= within) & (length(goal - pursuer) <= within)
    since = jnp.where(arrived, jnp.minimum(kept.since, situation.t), jnp.inf)
    passed = (situation.t >= since + hold) & (kept.number < len(points) - 1.0)
    return Wanted(u, turning, Progress(jnp.where(passed, kept.number + 1.0, kept.number), jnp.where(passed, jnp.inf, since)))


def _present(points: tuple[Waypoint, ...], situation: Situation, place: Scalar) -> tuple[Vector, Turning, tuple[Scalar, ...]]:
    """(g, turning of its frame, (speed, radius, time)) of the present waypoint."""
    values = _of_waypoint(points[0], situation)
    for index, point in enumerate(points[1:], 1):
        values = jax.tree.map(
            lambda new, old, index=index: jnp.where(place >= index, new, old), _of_waypoint(point, situation), values
        )
    return values


def _of_waypoint(point: Waypoint, situation: Situation) -> tuple[Vector, Turning, tuple[Scalar, ...]]:
    zero = situation.t * 0.0
    at = Vector(*(coordinate + zero for coordinate in point.at_m))
    numbers = (point.speed_m_s + zero, point.within_m + zero, point.hold_s + zero)
    if point.frame == "port":
        turning = Turning(situation.port * 0.0, situation.port * 0.0)
        return rotate_back(port_axes(situation.axis), at), turning, numbers
    goal = rotate_back(orbit_axes(situation.target), at) - situation.port
    return goal, orbit_turning(situation.target, situation.alpha_t), numbers


def build(parameters: Parameters) -> Guidance:
    """The guidance through these points."""
    kinds: Mapping[str, Need] = {"port": "axis", "lvlh": "orbit"}
    needs: list[tuple[Place, Need]] = [
        (("points", index, "frame"), kinds[point.frame])
        for index, point in enumerate(parameters.points)
        if point.frame == "lvlh" or any(point.at_m)
    ]
    return Guidance(partial(wanted, parameters.points), start, tuple(needs))


COMPONENT = Component(Parameters, build)
