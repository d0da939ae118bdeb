"""Differential drag: drag on the pursuer minus drag on the target. The plant integrates the target's motion without drag.

    d_f = m (a_p − a_t),   a = −½ ϱ β |v| v,   v_t: of the target,   v_p = R(v_t + ω_t×δ) + ν

β = C_d A/m: ballistic coefficient; ϱ: density, the same for both because they are close; v: inertial velocity, in P. The
atmosphere does not rotate. Rotation with the Earth would lower the relative speed on an eastward equatorial orbit by 0.5 km/s of
7.6 km/s, an eighth of the drag, and turn it by 4° on a polar orbit. The density on a given day is known only to a factor of two,
so draw it. No torque.

D. Vallado, "Fundamentals of astrodynamics and applications", 2013, §8.6.2.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from rvjax.campaign import Model, Quantity, scalar
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.effect import zero
from rvjax.components.registry import Component
from rvjax.physics.dynamics import Relative
from rvjax.physics.state import Numbers, Plant, State
from rvjax.physics.vectors import Channels, Scalar, Vector, cross, norm, rotate


class Parameters(Model):
    """Density of the air and ballistic coefficients."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"density_kg_m3": 1e-12, "pursuer_m2_kg": 0.01, "target_m2_kg": 0.005},)

    density_kg_m3: Quantity = scalar("kg/m³", at_least=0.0, doc="density ϱ of the air; at 500 km 1e-13 to 5e-12")
    pursuer_m2_kg: Quantity = scalar("m²/kg", at_least=0.0, doc="ballistic coefficient β of the pursuer, C_d A/m")
    target_m2_kg: Quantity = scalar("m²/kg", at_least=0.0, doc="ballistic coefficient β of the target, C_d A/m")


def push(t: Scalar, y: State, known: Relative, plant: Plant, memory: tuple[()], numbers: Numbers) -> Channels:
    """(m (a_p − a_t), 0)."""
    del t, memory
    port = y.target.v + cross(y.target.w, plant.port)
    pursuer = drag(rotate(known.r, port) + y.motion.nu, numbers.pursuer_m2_kg, numbers)
    target = drag(rotate(known.r, y.target.v), numbers.target_m2_kg, numbers)
    return Channels((pursuer - target) * plant.mass, y.motion.nu * 0.0)


def drag(v: Vector, ballistic: Scalar, numbers: Numbers) -> Vector:
    """a = −½ ϱ β |v| v [m/s²]; v in any frame [m/s]."""
    return v * (-0.5 * numbers.density_kg_m3 * ballistic * norm(v))


COMPONENT = Component(
    Parameters,
    lambda parameters: Disturbance(push),
    neutral=(zero("density_kg_m3"), zero("pursuer_m2_kg", "target_m2_kg")),
)
