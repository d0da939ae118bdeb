"""Two spacecraft in the inertial frame, propagated absolutely under a recorded wrench: the truth that a flight is held against.

    r̈_t = −μ r_t/|r_t|³,               q̇_t = ½ q_t ∘ ω_t,   J_t ω̇_t = −ω_t×J_t ω_t
    r̈_p = −μ r_p/|r_p|³ + C_p f/m,     q̇_p = ½ q_p ∘ Ω,     J Ω̇ = τ − Ω×JΩ
    ρ = C_pᵀ(r_p − r_t − C_t δ),   ν = C_pᵀ(ṙ_p − ṙ_t − C_t(ω_t×δ)),   R = C_pᵀC_t,   ω = Ω − R ω_t

C_t, C_p: from the target's and the pursuer's frame to the inertial one, by unit quaternions (scalar last). The inertial frame
is the target's frame at the first row. Nothing here is linearised, relative or shared with the code under test: NumPy and
SciPy only, DOP853 with rtol 1e-12. SI units.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

LONGEST_STEP_S = 0.25
"""Keeps the error of a step far below rtol times the distance from the Earth's centre, which is 7 µm."""
SPLINE_DEGREE = 7


class Constants(NamedTuple):
    """mass [kg], inertia (3, 3) and target_inertia (3, 3) [kg·m²], port δ (3,) in T [m], mu [m³/s²]."""

    mass: float
    inertia: Array
    target_inertia: Array
    port: Array
    mu: float


class Deviation(NamedTuple):
    """Largest distances between two tables of relative motion: m, m/s, rad, rad/s."""

    position: float
    velocity: float
    attitude: float
    rate: float


def columns(trace: pd.DataFrame, pattern: str, names: Sequence[str] = "xyz") -> Array:
    """The columns `pattern` with each name in turn for `*`, as an array of shape (rows, names)."""
    return np.array(trace[[pattern.replace("*", name) for name in names]], np.float64)


def recorded_wrench(trace: pd.DataFrame) -> Array:
    """(rows, 6): applied plus disturbance, in P [N, N·m]."""
    channels = ("fx", "fy", "fz", "tx", "ty", "tz")
    return columns(trace, "applied_*", channels) + columns(trace, "dist_*", channels)


def propagate(trace: pd.DataFrame, constants: Constants, breaks: Sequence[float] = (), rtol: float = 1e-12) -> pd.DataFrame:
    """The relative motion at the rows of a trace, from its first row and its recorded wrench alone.

    breaks: times [s] at which the wrench jumps. Each piece has a spline of its own, through the rows from its break on and
    before the next one, and is continued to its end.
    """
    t = trace["t_s"].to_numpy(np.float64)
    wrench = recorded_wrench(trace)
    edges = [t[0], *sorted(b for b in breaks if t[0] < b <= t[-1]), np.inf]
    y = _absolute(trace, constants)
    pieces: list[Array] = []
    for start, end in pairwise(edges):
        rows = (t >= start) & (t < end)
        spline = make_interp_spline(t[rows], wrench[rows], k=min(SPLINE_DEGREE, int(rows.sum()) - 1))
        stop = min(end, t[-1])
        times = np.union1d(t[rows], stop)
        solution = solve_ivp(
            _rate(constants, spline), (start, stop), y, "DOP853", times, rtol=rtol, atol=1e-3 * rtol, max_step=LONGEST_STEP_S
        )
        pieces.append(solution.y.T[: rows.sum()])
        y = solution.y[:, -1]
    return _relative(t, np.concatenate(pieces), constants)


def propagate_held(trace: pd.DataFrame, constants: Constants) -> pd.DataFrame:
    """The relative motion at the rows of a trace, by `held_states`."""
    return _relative(trace["t_s"].to_numpy(np.float64), held_states(trace, constants), constants)


def held_states(trace: pd.DataFrame, constants: Constants) -> Array:
    """(rows, 26) absolute states, from the first row of a trace and the mean wrench of each step, held over the step in P.

    A Runge–Kutta step of order 4 per row: smooth between two rows, so its error is far below what holding the wrench costs.
    """
    t = trace["t_s"].to_numpy(np.float64)
    means = columns(trace, "mean_*", ("fx", "fy", "fz", "tx", "ty", "tz"))
    states = [_absolute(trace, constants)]
    for k, h in enumerate(np.diff(t)):
        rate, y = _rate(constants, lambda _, wrench=means[k]: wrench), states[-1]
        k1 = rate(t[k], y)
        k2 = rate(t[k], y + 0.5 * h * k1)
        k3 = rate(t[k], y + 0.5 * h * k2)
        k4 = rate(t[k], y + h * k3)
        states.append(y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))
    return np.array(states)


def deviation(a: pd.DataFrame, b: pd.DataFrame) -> Deviation:
    """The largest distance over the rows of two tables of relative motion; the attitude's is the angle between the two."""

    def apart(pattern: str) -> float:
        return float(np.linalg.norm(columns(a, pattern) - columns(b, pattern), axis=1).max())

    between = Rotation.from_mrp(columns(a, "sigma_*")).inv() * Rotation.from_mrp(columns(b, "sigma_*"))
    return Deviation(apart("rho_*_m"), apart("nu_*_m_s"), float(between.magnitude().max()), apart("omega_*_rad_s"))


def _absolute(trace: pd.DataFrame, constants: Constants) -> Array:
    """(26,): r_t, v_t, r_p, v_p, q_t, q_p in the inertial frame, ω_t in T, Ω in P, of the first row of a trace."""
    first = trace.iloc[:1]
    r, v, w = (columns(first, f"target_{name}")[0] for name in ("r_*_m", "v_*_m_s", "w_*_rad_s"))
    rho, nu, omega = (columns(first, name)[0] for name in ("rho_*_m", "nu_*_m_s", "omega_*_rad_s"))
    attitude = Rotation.from_mrp(columns(first, "sigma_*")[0])
    position = r + constants.port + attitude.apply(rho)
    velocity = v + np.cross(w, constants.port) + attitude.apply(nu)
    turning = omega + attitude.inv().apply(w)
    return np.concatenate([r, v, position, velocity, [0.0, 0.0, 0.0, 1.0], attitude.as_quat(), w, turning])


def _rate(constants: Constants, wrench: Callable[[float], Array]) -> Callable[[float, Array], Array]:
    """The right-hand side for the 26 numbers of `_absolute`."""
    inertia, target_inertia = constants.inertia, constants.target_inertia
    inverse, target_inverse = np.linalg.inv(inertia), np.linalg.inv(target_inertia)

    def fall(r: Array) -> Array:
        return r * (-constants.mu / (r @ r) ** 1.5)

    def rate(t: float, y: Array) -> Array:
        r_t, v_t, r_p, v_p, q_t, q_p, w_t, w_p = np.split(y, (3, 6, 9, 12, 16, 20, 23))
        push = wrench(t)
        force = _matrix(q_p) @ push[:3] / constants.mass
        alpha_t = target_inverse @ -_cross(w_t, target_inertia @ w_t)
        alpha_p = inverse @ (push[3:] - _cross(w_p, inertia @ w_p))
        return np.concatenate([v_t, fall(r_t), v_p, fall(r_p) + force, _spin(q_t, w_t), _spin(q_p, w_p), alpha_t, alpha_p])

    return rate


def _relative(t: Array, y: Array, constants: Constants) -> pd.DataFrame:
    """ρ, ν, σ, ω in the columns of a trace, from rows of absolute states."""
    r_t, v_t, r_p, v_p, q_t, q_p, w_t, w_p = np.split(y, (3, 6, 9, 12, 16, 20, 23), axis=1)
    target, pursuer = Rotation.from_quat(q_t), Rotation.from_quat(q_p)
    rho = pursuer.inv().apply(r_p - r_t - target.apply(constants.port))
    nu = pursuer.inv().apply(v_p - v_t - target.apply(np.cross(w_t, constants.port)))
    attitude = target.inv() * pursuer
    omega = w_p - attitude.inv().apply(w_t)
    parts = {"rho_*_m": rho, "nu_*_m_s": nu, "sigma_*": attitude.as_mrp(), "omega_*_rad_s": omega}
    table = {pattern.replace("*", axis): part[:, i] for pattern, part in parts.items() for i, axis in enumerate("xyz")}
    return pd.DataFrame({"t_s": t, **table})


def _cross(a: Array, b: Array) -> Array:
    """a × b of two vectors of shape (3,)."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _matrix(q: Array) -> Array:
    """C(q), from the body's frame to the inertial one; a quaternion that has drifted off norm 1 is normalised here."""
    x, y, z, w = q / np.sqrt(q @ q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _spin(q: Array, w: Array) -> Array:
    """q̇ = ½ q ∘ (ω, 0); ω in the body's frame."""
    return 0.5 * np.append(q[3] * w + _cross(q[:3], w), -q[:3] @ w)
