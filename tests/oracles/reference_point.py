"""The reference point of the guidance `corridor`, written again in NumPy and SciPy from its documentation, for a trace.

Vectors have shape (3,) and are in the target's frame T; SI units.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def columns(trace: pd.DataFrame, pattern: str) -> Array:
    """(rows, 3)."""
    return np.array(trace[[pattern.replace("*", axis) for axis in "xyz"]], np.float64)


def turn_of_lvlh(r: Array, v: Array, w: Array, alpha: Array) -> tuple[Array, Array]:
    """(c, ċ) of LVLH relative to T, by the quotient rule on h/|r|² with ḣ = −ω_t×h and d|r|²/dt = 2rᵀv."""
    h, r2 = np.cross(r, v), r @ r
    return h / r2 - w, (-np.cross(w, h) * r2 - h * 2.0 * (r @ v)) / r2**2 - alpha


def share(error: float, accepted: float) -> float:
    """1 up to what is accepted, 0 from twice that on."""
    return float(np.interp(error, [accepted, 2.0 * accepted], [1.0, 0.0]))


def no_longer(a: Array, most: float) -> Array:
    """a, cut to a length."""
    size = float(np.linalg.norm(a))
    return a if size <= most else a / size * most


def path(trace: pd.DataFrame, port: Array, axis: Array, inertia: Array, numbers: Mapping[str, float]) -> tuple[Array, Array]:
    """(p, ṗ), each (rows, 3): in the first row where the pursuer is, in every other row a step on from the row before. A
    recursion over all rows would not do: opposite to the gate it multiplies the last digit."""
    t = trace["t_s"].to_numpy(np.float64)
    rho, nu, sigma = (columns(trace, name) for name in ("rho_*_m", "nu_*_m_s", "sigma_*"))
    r, v, w = (columns(trace, f"target_{name}") for name in ("r_*_m", "v_*_m_s", "w_*_rad_s"))
    known = columns(trace, "ref_*_m"), columns(trace, "ref_*_m_s")
    back = Rotation.from_mrp(sigma)  # P → T
    place, speed = back.apply(rho), back.apply(nu)
    points, velocities = [place[0]], [speed[0] - np.cross(w[0], place[0])]
    for k, (point, velocity) in enumerate(zip(*known, strict=True)):
        if k == len(t) - 1:
            break
        alpha = -np.linalg.solve(inertia, np.cross(w[k], inertia @ w[k]))
        angle = 4.0 * np.arctan(np.linalg.norm(sigma[k]))
        u, c, swing = wanted(point, velocity, turn_of_lvlh(r[k], v[k], w[k], alpha), port, axis, numbers,
                             float(np.linalg.norm(place[k] - point)), angle)  # fmt: skip
        q = port + point
        inside = velocity - np.cross(c, q)
        b = no_longer((u - inside) / numbers["time_constant_s"], numbers["acceleration"])
        accel = b + 2.0 * np.cross(c, inside) + np.cross(c, np.cross(c, q)) + np.cross(swing, q)
        h = t[k + 1] - t[k]
        points.append(point + h * velocity + 0.5 * h * h * accel)
        velocities.append(velocity + h * accel)
    return np.array(points), np.array(velocities)


def wanted(
    p: Array,
    velocity: Array,
    orbit: tuple[Array, Array],
    port: Array,
    axis: Array,
    numbers: Mapping[str, float],
    lag: float,
    angle: float,
) -> tuple[Array, Array, Array]:
    """(u, c, ċ)."""
    follows, most, gate = numbers["time_constant_s"], numbers["acceleration"], numbers["gate_m"]
    slope = min(numbers["slope"], 1.0 / (4.0 * follows))
    close = share(lag, numbers["lag_m"])
    x = float(axis @ p)
    beside = p - x * axis
    if np.linalg.norm(beside) <= 0.1 * x + 0.02 and x <= 1.1 * gate:
        aligned = share(np.tan(angle / 4.0), np.tan(numbers["aligned_rad"] / 4.0))
        end = min(numbers["end_speed_m_s"], 4.0 * follows * most, x / (4.0 * follows))
        v = min(numbers["speed_m_s"], most / slope, max(slope * x, end))
        zero = np.zeros(3)
        return -axis * v * close * aligned - min(2.0 * slope, 0.25 / follows) * beside, zero, zero
    q, goal = port + p, port + 1.05 * gate * axis
    distance, reach = float(np.linalg.norm(q)), float(np.linalg.norm(goal))
    e, g = q / distance, goal / reach
    fast = min(numbers["far_speed_m_s"], most / slope)
    s = float(np.clip((1.5 - distance / reach) / 0.5, 0.0, 1.0))
    radial = float(np.clip(slope * (reach - distance), -fast, fast))
    across = np.cross(np.cross(e, g), e)
    tangent = across / np.linalg.norm(across)
    around = min(fast, slope * distance * float(np.linalg.norm(g - e)))
    rate = float(e @ velocity) / (0.5 * reach) if 0.0 < s < 1.0 else 0.0
    c, swing = orbit
    return close * (radial * e + s * around * tangent), (1.0 - s) * c, (1.0 - s) * swing + rate * c
