"""Interface of an effect: functions of a sample at an instant.

    w = wrench(body, x, numbers)                 on the pursuer, from the state x of the effect
    ẋ = rate(body, a, α, x, numbers)             a, α: acceleration of the pursuer under all wrenches

The mass and inertia of the campaign are those of the pursuer without what an effect moves. So the reaction follows from the
state, and no equation has an unknown on both sides. An effect whose reaction does depend on the acceleration, such as the
tension of a rod, is `implicit`: it sees the acceleration under all other wrenches; a campaign has one such effect at most.

The wrench acts on the centre of mass of the instant. A place that is a number of the effect is from there, so it moves in the
body as far as the propellant moves the centre of mass; `Body.centre` is where that is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rvjax.columns import Column
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels, Scalar, Symmetric, Vector, cross


class Body(NamedTuple):
    """The pursuer at an instant, in P.

    t: time [s]; rate: inertial angular velocity Ω [rad/s]; mass [kg], inertia and its inverse about the centre of mass [kg·m²];
    centre: of mass, from the reference point [m]. free_accel [m/s²], free_alpha [rad/s²]: acceleration of the centre of mass
    and angular acceleration under the applied wrench, the disturbances and the effects that are not implicit; without
    gravity, which acts on the pursuer and on what moves in it alike.
    """

    t: Scalar
    rate: Vector
    mass: Scalar
    inertia: Symmetric
    inertia_inverse: Symmetric
    centre: Vector
    free_accel: Vector
    free_alpha: Vector


class Effect(NamedTuple):
    """start(numbers) → x at t = 0; wrench(body, x, numbers) → force and torque on the centre of mass [N, N·m], in P;
    rate(body, a, α, x, numbers) → ẋ; record(body, x, numbers) → signals for the trace, by name.

    signals: unit and meaning of each signal. implicit: the wrench depends on the free acceleration.
    """

    start: Callable[[Numbers], Any]
    wrench: Callable[[Body, Any, Numbers], Channels]
    rate: Callable[[Body, Vector, Vector, Any, Numbers], Any]
    record: Callable[[Body, Any, Numbers], Mapping[str, Any]] = lambda body, x, numbers: {}
    signals: Mapping[str, Column] = {}
    implicit: bool = False


def turned(rate: Vector, alpha: Vector, arm: Vector) -> Vector:
    """α×r + Ω×(Ω×r): acceleration of a point that is fixed in the body at r from its centre of mass, relative to it."""
    return cross(alpha, arm) + cross(rate, cross(rate, arm))
