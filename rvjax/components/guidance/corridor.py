"""To a gate on the docking axis, and along the axis by a speed profile.

    q = δ + p;   n: docking axis, x = nᵀp, l = p − n x;   gate γ = δ + 1.05 x_g n;   e = q/|q|, g = γ/|γ|
    outside       u = c₁ [v_e e + s v_t t],   v_e = κ'(|γ| − |q|),   v_t = κ'|q||g − e|,   each v_far' at most
    in the axis   u = −c₁ c₂ v(x) n − 2κ' l,   v(x) = min(v', max(κ'x, min(v_end, x/(4T))))

t: unit vector across e, toward g. κ' = min(κ, 1/(4T)); v' = min(v, a/κ') and v_far' likewise: the point brakes with a at most.

Outside, the reference point comes down radially, at rest in LVLH but for this. From 1.5 |γ| on, s goes from 0 to 1: the frame
of u takes on the turning of the target, and the point goes round to the gate. It enters the axis at x ≤ 1.1 x_g, less than 0.1
x + 2 cm beside it; from there on u is relative to T. c₁, c₂: 1 for a pursuer up to lag_m from the point and with an attitude
error up to aligned_deg, 0 from twice these values on. So the point waits in the axis for a pursuer that is not aligned, and
stops for one that falls behind.

The keep-out zone must be smaller than |γ|. A straight corridor with a gate as a hold point: W. Fehse, "Automated rendezvous and
docking of spacecraft", 2003, §5.3; the profile is this project's.
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from rvjax.campaign import Quantity, scalar
from rvjax.components.guidance.interface import (
    Guidance,
    GuidanceParameters,
    Situation,
    Wanted,
    brakes,
    granted,
    in_target,
    length,
    limited,
)
from rvjax.components.registry import Component
from rvjax.physics.elementary import tan
from rvjax.physics.orbit_frame import Turning, orbit_turning
from rvjax.physics.state import Numbers, Path
from rvjax.physics.vectors import Scalar, Vector, dot, norm

BEYOND, ENTRY = 1.05, 1.1
"""How far from the docking point the point goes to the axis and enters it, in parts of the gate's distance."""
TURNING = 1.5
"""The distance, in parts of |γ|, from which the reference point takes on the turning of the target."""
BESIDE, LEAST = 0.1, 0.02
"""The point is in the axis where it is beside it by less than BESIDE x + LEAST m."""


class Parameters(GuidanceParameters):
    """Gate, speeds, and when the pursuer may go on."""

    gate_m: Quantity = scalar("m", default=8.0, above=0.0, doc="distance x_g of the gate from the docking point")
    far_speed_m_s: Quantity = scalar("m/s", default=0.4, above=0.0, doc="largest speed v_far outside")
    speed_m_s: Quantity = scalar("m/s", default=0.2, above=0.0, doc="largest speed v in the axis")
    end_speed_m_s: Quantity = scalar("m/s", default=0.02, at_least=0.0, doc="speed v_end near the docking point")
    slope: Quantity = scalar("1/s", default=0.05, above=0.0, doc="speed per distance κ")
    aligned_rad: Quantity = scalar(
        "rad", key="aligned_deg", default=5.0, above=0.0, below=180.0, doc="attitude error up to which the pursuer may go on"
    )
    lag_m: Quantity = scalar("m", default=0.5, above=0.0, doc="distance from the reference point up to which it may go on")


def wanted(situation: Situation, path: Path, kept: Any, numbers: Numbers) -> Wanted:
    """u in the frame that turns with (1 − s)(ω_o − ω_t) relative to T; in the axis T itself."""
    axis, p = situation.axis, path.point
    along = dot(axis, p)
    beside = p - axis * along
    near = (norm(beside) <= BESIDE * along + LEAST) & (along <= ENTRY * numbers.gate_m)
    slope, _ = brakes(numbers.speed_m_s, numbers)
    close = granted(in_target(situation) - p, numbers.lag_m)
    aligned = granted(situation.motion.sigma, tan(0.25 * numbers.aligned_rad))
    across = jnp.minimum(2.0 * slope, 0.25 / numbers.time_constant_s)
    inside = axis * (-close * aligned * profile(along, numbers)) - beside * across
    outside, turning = toward_the_gate(situation, path, numbers)
    u = Vector(*(jnp.where(near, i, o * close) for i, o in zip(inside.parts(), outside.parts(), strict=True)))
    return Wanted(u, turning.scaled(jnp.where(near, 0.0, 1.0)), kept)


def profile(along: Scalar, numbers: Numbers) -> Scalar:
    """v(x)."""
    slope, most = brakes(numbers.speed_m_s, numbers)
    end = jnp.minimum(numbers.end_speed_m_s, 4.0 * numbers.time_constant_s * numbers.acceleration)
    return jnp.minimum(most, jnp.maximum(slope * along, jnp.minimum(end, along * (0.25 / numbers.time_constant_s))))


def toward_the_gate(situation: Situation, path: Path, numbers: Numbers) -> tuple[Vector, Turning]:
    """u outside of the axis for c₁ = 1, and the turning of its frame."""
    slope, most = brakes(numbers.far_speed_m_s, numbers)
    q, gate = situation.port + path.point, situation.port + situation.axis * (BEYOND * numbers.gate_m)
    distance, gate_distance = length(q), length(gate)
    e, goal = q * (1.0 / distance), gate * (1.0 / gate_distance)
    stretch = 1.0 / ((TURNING - 1.0) * gate_distance)
    rest = jnp.clip((distance - gate_distance) * stretch, 0.0, 1.0)
    down = jnp.clip((gate_distance - distance) * slope, -most, most)
    round_it = limited(tangent(e, goal) * (distance * slope * length(goal - e)), most)
    orbit = orbit_turning(situation.target, situation.alpha_t)
    rate = jnp.where((rest > 0.0) & (rest < 1.0), dot(e, path.velocity) * stretch, 0.0)
    return e * down + round_it * (1.0 - rest), Turning(orbit.rate * rest, orbit.accel * rest + orbit.rate * rate)


def tangent(e: Vector, goal: Vector) -> Vector:
    """t; where the gate is on the other side of the target, any direction across the axis."""
    across = goal - e * dot(e, goal)
    upright = jnp.abs(goal.z) > 0.5
    other = Vector(jnp.where(upright, 0.0, -goal.y), jnp.where(upright, -goal.z, goal.x), jnp.where(upright, goal.y, 0.0))
    opposite = (dot(across, across) < 1e-6) & (dot(e, goal) < 0.0)
    t = Vector(*(jnp.where(opposite, o, a) for o, a in zip(other.parts(), across.parts(), strict=True)))
    return t * (1.0 / length(t))


COMPONENT = Component(Parameters, lambda parameters: Guidance(wanted, needs=((("use",), "axis"),)))
