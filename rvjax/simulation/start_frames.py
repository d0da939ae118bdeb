"""Frames of the start: the relative motion (ρ, ν, σ, ω) at t = 0 of a pursuer whose motion is given in a frame.

    frame        origin                        axes
    port         docking point δ               x along the docking axis, outward; y and z: those of T after the shortest turn
                                               that takes the x axis of T to the docking axis (for −x half a turn about z)
    lvlh         target's centre of mass       z = −r_t/|r_t|, toward the Earth (R-bar); y = −h/|h|, against the orbit normal
                                               (H-bar); x = y×z, along the velocity of a circular orbit (V-bar);  h = r_t×v_t
    pursuer      docking point δ               those of P

    relative_to  velocity of rest at p         rate of rest ω_r
    port         v_t + ω_t×p                   ω_t              at rest relative to the port: it turns with the target
    lvlh         v_t + ω_o×p                   ω_o = h/|r_t|²   at rest in LVLH, which turns with the orbit
    inertial     v_t                           0                with the velocity of the target's centre, not turning

Given x, ẋ (position and velocity), a (attitude_mrp), w (rate). A takes components in the frame to T. Vectors are in T, of P only
ρ, ν, ω and w:

    σ: R(σ) = R(a),  for lvlh R(σ) = R(a) Aᵀ        R = R(σ), T → P;  for pursuer A = Rᵀ
    p = A x + δ,  for lvlh p = A x
    ρ = R (p − δ)
    ν = R [A ẋ + ω_r×(p − δ) + (ω_r − ω_t)×δ]       pursuer minus docking point, whose velocity is v_t + ω_t×δ
    ω = w + R (ω_r − ω_t)

The default of relative_to is the frame, for pursuer it is port. A hold point 100 m behind the target on V-bar is x = [-100, 0, 0]
in lvlh, one 30 m below it on R-bar [0, 0, 30]. Conventions of LVLH: W. Fehse, "Automated rendezvous and docking of spacecraft",
2003, §3.1.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign.start import Frame, Rest
from rvjax.campaign.triples import Three, unit
from rvjax.physics.state import Motion, TargetMotion
from rvjax.physics.vectors import Rotation, Vector, cross, dot, rotate, rotate_back, rotation

Values = NDArray[np.float64]
Quaternion = tuple[Values, Vector]
"""Scalar and vector part, (cos(φ/2), e sin(φ/2)) for a turn by φ about e."""


class Given(NamedTuple):
    """Position [m] and velocity [m/s] in the frame; attitude (MRP); rate [rad/s], in P."""

    position: Vector
    velocity: Vector
    attitude: Vector
    rate: Vector


def docking_axis(given: Three | None, port: Vector) -> tuple[Vector, NDArray[np.bool_]]:
    """The docking axis in T, a unit vector, and where there is one: the given direction, or else δ/|δ|, with δ = 0 none."""
    if given is not None:
        return Vector(*(np.full_like(port.x, part) for part in unit(given))), np.full(port.x.shape, True)
    length = np.sqrt(sum(part * part for part in port.parts()))
    return port / np.where(length > 0.0, length, 1.0), length > 0.0


def start_motion(
    frame: Frame, relative_to: Rest, given: Given, target: TargetMotion, port: Vector, axis: tuple[Vector, NDArray[np.bool_]]
) -> Motion:
    """(ρ, ν, σ, ω) at t = 0. port: δ, in T; axis: of `docking_axis`; where there is none, it is the x axis of T."""
    sigma, axes = given.attitude, Rotation(*(Vector(*row) for row in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))))
    if frame == "lvlh":
        axes = lvlh_axes(target)
        sigma = _mrp(_product(_of_mrp(given.attitude), _of_rotation(axes)))
    elif frame == "port":
        direction, known = axis
        axes = port_axes(Vector(np.where(known, direction.x, 1.0), direction.y, direction.z))
    turn = rotation(sigma)
    axes = turn if frame == "pursuer" else axes
    away = rotate_back(axes, given.position) - (port if frame == "lvlh" else port * 0.0)
    rest = {"port": target.w, "lvlh": orbital_rate(target), "inertial": target.w * 0.0}[relative_to]
    carried = cross(rest, away) + cross(rest - target.w, port)
    return Motion(
        rho=rotate(turn, away),
        nu=rotate(turn, rotate_back(axes, given.velocity) + carried),
        sigma=sigma,
        omega=given.rate + rotate(turn, rest - target.w),
    )


def orbital_rate(target: TargetMotion) -> Vector:
    """Inertial rate of LVLH, ω_o = r×v/|r|², in T [rad/s]."""
    return cross(target.r, target.v) / dot(target.r, target.r)


def lvlh_axes(target: TargetMotion) -> Rotation:
    """T → LVLH: the rows are x (V-bar), y (H-bar) and z (R-bar) in T."""
    z, y = -_unit(target.r), -_unit(cross(target.r, target.v))
    return Rotation(cross(y, z), y, z)


def port_axes(n: Vector) -> Rotation:
    """T → port: the rows are the axes x = n, y, z in T. n: docking axis, a unit vector.

    y = (−n_y, 1 − k n_y², −k n_y n_z),  z = (−n_z, −k n_y n_z, 1 − k n_z²),  k = 1/(1 + n_x) = (1 − n_x)/(n_y² + n_z²)
    """
    size = np.maximum(np.abs(n.y), np.abs(n.z))
    beside = size > 0.0
    b, c = (np.where(beside, part / np.where(beside, size, 1.0), other) for part, other in ((n.y, 1.0), (n.z, 0.0)))
    back = n.x < 0.0
    scale = np.where(back, (1.0 - n.x) / (b * b + c * c), size * size / (1.0 + np.where(back, 0.0, n.x)))
    return Rotation(n, Vector(-n.y, 1.0 - scale * b * b, -(scale * b * c)), Vector(-n.z, -(scale * b * c), 1.0 - scale * c * c))


def _unit(a: Vector) -> Vector:
    return a / np.sqrt(dot(a, a))


def _of_mrp(sigma: Vector) -> Quaternion:
    """q_0 = (1 − σᵀσ)/(1 + σᵀσ), q = 2σ/(1 + σᵀσ)."""
    s2 = dot(sigma, sigma)
    return (1.0 - s2) / (1.0 + s2), sigma * (2.0 / (1.0 + s2))


def _of_rotation(r: Rotation) -> Quaternion:
    """From the row of 4 q qᵀ with the largest diagonal entry, divided by its length (S. Shepperd, "Quaternion from rotation
    matrix", 1978)."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = (row.parts() for row in (r.a, r.b, r.c))
    scalars: tuple[Any, ...] = (1.0 + xx + yy + zz, yz - zy, zx - xz, xy - yx)
    rows = (
        scalars,
        (scalars[1], 1.0 + xx - yy - zz, xy + yx, xz + zx),
        (scalars[2], xy + yx, 1.0 - xx + yy - zz, yz + zy),
        (scalars[3], xz + zx, yz + zy, 1.0 - xx - yy + zz),
    )
    most, best = rows[0][0], rows[0]
    for index, row in enumerate(rows[1:], start=1):
        larger = row[index] > most
        most = np.where(larger, row[index], most)
        best = tuple(np.where(larger, new, old) for new, old in zip(row, best, strict=True))
    size = np.sqrt(sum(part * part for part in best))
    return best[0] / size, Vector(*best[1:]) / size


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    """The quaternion of R(a) R(b)."""
    return a[0] * b[0] - dot(a[1], b[1]), b[1] * a[0] + a[1] * b[0] - cross(a[1], b[1])


def _mrp(q: Quaternion) -> Vector:
    """σ of the shorter turn: |σ| ≤ 1, but for rounding."""
    return q[1] * (np.copysign(1.0, q[0]) / (1.0 + np.abs(q[0])))
