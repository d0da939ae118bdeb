"""The effects of a flight together: their wrenches on the pursuer, the rates of their states, their signals.

    a = F/m,   α = J⁻¹(M − Ω×JΩ),   F, M: applied wrench, disturbances and the wrenches of all effects

The wrenches follow from the states; that of the implicit effect also from the acceleration under all other wrenches. So the
exchange of momentum between the pursuer and what moves in it is exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rvjax.components.effects.interface import Body, Effect
from rvjax.physics.dynamics import Relative
from rvjax.physics.state import Numbers, Plant
from rvjax.physics.vectors import Channels, Scalar, Vector, apply, cross


def effects_sum(
    effects: Sequence[Effect],
    numbers: Sequence[Numbers],
    states: Sequence[Any],
    t: Scalar,
    known: Relative,
    plant: Plant,
    others: Channels,
) -> tuple[Channels, tuple[Any, ...], tuple[Any, ...]]:
    """(total wrench on the centre of mass, rates of the states, signals). others: the wrench without the effects [N, N·m]."""
    order = sorted(range(len(effects)), key=lambda i: effects[i].implicit)
    total, bodies = others, dict[int, Body]()
    for i in order:
        bodies[i] = _body(t, known, plant, total)
        total = total + effects[i].wrench(bodies[i], states[i], numbers[i])
    accel, alpha = acceleration(known, plant, total)
    indices = range(len(effects))
    rates = tuple(effects[i].rate(bodies[i], accel, alpha, states[i], numbers[i]) for i in indices)
    return total, rates, tuple(effects[i].record(bodies[i], states[i], numbers[i]) for i in indices)


def acceleration(known: Relative, plant: Plant, wrench: Channels) -> tuple[Vector, Vector]:
    """(a, α) of the pursuer under a wrench, in P [m/s², rad/s²]."""
    gyro = cross(known.omega_p, apply(plant.inertia, known.omega_p))
    return wrench.force * (1.0 / plant.mass), apply(plant.inertia_inverse, wrench.torque - gyro)


def _body(t: Scalar, known: Relative, plant: Plant, wrench: Channels) -> Body:
    accel, alpha = acceleration(known, plant, wrench)
    return Body(t, known.omega_p, plant.mass, plant.inertia, plant.inertia_inverse, plant.centre, accel, alpha)
