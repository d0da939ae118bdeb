"""The motion of target and pursuer in an inertial frame, from a trace, which is relative.

    r_I(t), v_I(t)    of the target: the Kepler orbit through C(0)ᵀ r_t(0), C(0)ᵀ v_t(0)       C: I → T
    C(t)              takes the triad of r_I, h_I = r_I×v_I, h_I×r_I to that of r_t, h_t = r_t×v_t, h_t×r_t
    r_p = r_I + Cᵀ(δ + Rᵀρ),   v_p = v_I + Cᵀ(ω_t×δ + Rᵀν)                                      R(σ): T → P
    R C               the attitude of the pursuer, I → P;   Ω = ω + R ω_t, its inertial rate in P

I: the perifocal frame of the campaign, turned by the orientation of the orbit plane. C(0) = R(attitude_mrp) of the target. The
target moves on a Kepler orbit (`rvjax.physics.dynamics`), so its attitude follows from r_t and v_t, which are resolved in T, and
no error of an integration adds up. Symbols: `rvjax.physics.state`. Arrays: (rows, 3) and (rows, 3, 3), SI.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rvjax.analysis.trace_frames import rotation
from rvjax.export.exported import Exported, Numbers
from rvjax.physics.constants import MU_EARTH


@dataclass(frozen=True)
class Body:
    """position [m], velocity [m/s]: inertial, resolved in I. attitude: I → body. rate: inertial, in the body's frame [rad/s]."""

    position: Numbers
    velocity: Numbers
    attitude: Numbers
    rate: Numbers


@dataclass(frozen=True)
class Absolute:
    """Target and pursuer at the times t [s]. The position of the pursuer is that of its centre of mass."""

    t: Numbers
    target: Body
    pursuer: Body


def absolute(trace: Exported, attitude_mrp: Numbers, port: Numbers, plane: Numbers) -> Absolute:
    """The inertial motion of a trace whose first row is at t = 0. attitude_mrp: of the target at t = 0, perifocal frame → T.
    port: δ [m]. plane: perifocal frame → I, (3, 3)."""
    t = trace.frame["t_s"].to_numpy(dtype=float)
    r, v, w = (trace.vector(form) for form in ("target_r_{}_m", "target_v_{}_m_s", "target_w_{}_rad_s"))
    to_inertial = plane @ rotation(attitude_mrp[None])[0].T
    position, velocity = kepler(to_inertial @ r[0], to_inertial @ v[0], t)
    body = np.swapaxes(_triad(r, v), 1, 2) @ _triad(position, velocity)
    relative = rotation(trace.vector("sigma_{}"))
    away = port + _back(relative, trace.vector("rho_{}_m"))
    drift = np.cross(w, port) + _back(relative, trace.vector("nu_{}_m_s"))
    rate = trace.vector("omega_{}_rad_s") + np.einsum("tij,tj->ti", relative, w)
    pursuer = Body(position + _back(body, away), velocity + _back(body, drift), relative @ body, rate)
    return Absolute(t, Body(position, velocity, body, w), pursuer)


def orbit_plane(node_deg: float, inclination_deg: float, perigee_deg: float) -> Numbers:
    """R₃(Ω) R₁(i) R₃(ω), perifocal frame → I. Ω: of the ascending node; i: inclination; ω: argument of perigee."""
    node, perigee, tilt = _about_z(node_deg), _about_z(perigee_deg), np.radians(inclination_deg)
    cos, sin = np.cos(tilt), np.sin(tilt)
    return node @ np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]) @ perigee


def kepler(r: Numbers, v: Numbers, t: Numbers) -> tuple[Numbers, Numbers]:
    """Position and velocity on an elliptic orbit at the times t since r, v.

    √(μ/a³) t = E − (1 − r₀/a) sin E + (rᵀv/√(μa)) (1 − cos E),   E: change of the eccentric anomaly, by Newton's method
    r(t) = f r + g v,   f = 1 − (a/r₀)(1 − cos E),   g = t − √(a³/μ)(E − sin E).
    R. Battin, "An introduction to the mathematics and methods of astrodynamics", 1999, §4.3.
    """
    distance = float(np.linalg.norm(r))
    axis = 1.0 / (2.0 / distance - float(v @ v) / MU_EARTH)
    motion, radial = np.sqrt(MU_EARTH / axis**3), float(r @ v) / np.sqrt(MU_EARTH * axis)
    near = 1.0 - distance / axis
    mean = motion * t
    change = mean.copy()
    for _ in range(50):
        cos, sin = np.cos(change), np.sin(change)
        rest = change - near * sin + radial * (1.0 - cos) - mean
        step = rest / (1.0 - near * cos + radial * sin)
        change = change - step
        if np.max(np.abs(step), initial=0.0) < 1e-15:
            break
    cos, sin = np.cos(change), np.sin(change)
    now = axis * (1.0 - near * cos + radial * sin)
    f, g = 1.0 - axis / distance * (1.0 - cos), t - (change - sin) / motion
    f_rate, g_rate = -np.sqrt(MU_EARTH * axis) / (now * distance) * sin, 1.0 - axis / now * (1.0 - cos)
    return f[:, None] * r + g[:, None] * v, f_rate[:, None] * r + g_rate[:, None] * v


def _triad(r: Numbers, v: Numbers) -> Numbers:
    """The unit vectors along r, h×r and h as rows."""
    h = np.cross(r, v)
    out, normal = r / np.linalg.norm(r, axis=1, keepdims=True), h / np.linalg.norm(h, axis=1, keepdims=True)
    return np.stack([out, np.cross(normal, out), normal], axis=1)


def _back(matrices: Numbers, vectors: Numbers) -> Numbers:
    """Mᵀ v of each row."""
    return np.einsum("tij,ti->tj", matrices, vectors)


def _about_z(angle_deg: float) -> Numbers:
    cos, sin = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
