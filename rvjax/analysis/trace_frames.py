"""Frames and attitudes of the rows of a trace, in NumPy: a report and an export need no JAX (`rvjax.physics` has the same for
flights).

    R(σ) = I − 4(1−σᵀσ)/(1+σᵀσ)² σ^× + 8/(1+σᵀσ)² (σ^×)²                   attitude T → P of modified Rodrigues parameters
    q = (2σ, 1 − σᵀσ)/(1 + σᵀσ) = (e sin(φ/2), cos(φ/2))                    its quaternion, scalar last
    z = −r/|r| (R-bar),   y = −h/|h| (H-bar),   x = y × z (V-bar),   h = r × v                    LVLH

Quaternions keep their sign from row to row, also where the parameters jump to their shadow set. Arrays: (n, 3), (n, 4) and
(n, 3, 3), SI.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.columns import AXES

Values = NDArray[np.float64]


def vectors(trace: pd.DataFrame, form: str) -> Values:
    """(n, 3) of a trace. form: of its columns, with {} where the axis stands, such as `rho_{}_m`."""
    return trace[[form.format(axis) for axis in AXES]].to_numpy(dtype=float)


def rotation(sigma: Values) -> Values:
    """R(σ) of each row."""
    x, y, z = sigma.T
    zero, s2 = np.zeros_like(x), np.sum(sigma * sigma, axis=1)[:, None, None]
    skew = np.stack([np.stack(row, axis=1) for row in ((zero, -z, y), (z, zero, -x), (-y, x, zero))], axis=1)
    return np.eye(3) - 4.0 * (1.0 - s2) / (1.0 + s2) ** 2 * skew + 8.0 / (1.0 + s2) ** 2 * (skew @ skew)


def quaternions_of_mrp(sigma: Values) -> Values:
    """q of each row of σ."""
    square = np.sum(sigma * sigma, axis=1, keepdims=True)
    return _continuous(np.concatenate([2.0 * sigma, 1.0 - square], axis=1) / (1.0 + square))


def quaternions(attitude: Values) -> Values:
    """(e sin(φ/2), cos(φ/2)) of each matrix, for frames that are turned by φ about e; the first with a scalar of at least 0.

    The largest component is computed by a root, so none cancels. S. Shepperd, "Quaternion from rotation matrix", J. Guidance and
    Control, 1978.
    """
    m = attitude
    trace = np.trace(m, axis1=1, axis2=2)
    squares = np.stack([1.0 + 2.0 * m[:, i, i] - trace for i in range(3)] + [1.0 + trace], axis=1)
    pairs = np.empty((len(m), 4, 4))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        pairs[:, j, k] = pairs[:, k, j] = m[:, j, k] + m[:, k, j]
        pairs[:, i, 3] = pairs[:, 3, i] = m[:, j, k] - m[:, k, j]
    for i in range(4):
        pairs[:, i, i] = squares[:, i]
    best = pairs[np.arange(len(m)), np.argmax(squares, axis=1)]
    q = best / np.linalg.norm(best, axis=1, keepdims=True)
    q[0] *= 1.0 if q[0, 3] >= 0.0 else -1.0
    return _continuous(q)


def turned(q: Values, v: Values) -> Values:
    """v + 2 u × (u × v + q₄ v), u: the vector part: vectors resolved in the frame that q turns to, resolved in the frame that it
    turns from."""
    u = q[:, :3]
    return v + 2.0 * np.cross(u, np.cross(u, v) + q[:, 3:] * v)


def lvlh(r: Values, v: Values) -> Values:
    """LVLH → T of each row: x, y, z as columns. r, v: of the target, inertial, resolved in T."""
    h = np.cross(r, v)
    z, y = -r / np.linalg.norm(r, axis=1, keepdims=True), -h / np.linalg.norm(h, axis=1, keepdims=True)
    return np.stack([np.cross(y, z), y, z], axis=2)


def _continuous(q: Values) -> Values:
    """Each quaternion with the sign that is nearer to the one before it."""
    along = np.sum(q[1:] * q[:-1], axis=1)
    signs = np.where(along < 0.0, -1.0, 1.0)
    return q * np.concatenate([[1.0], np.cumprod(signs)])[:, None]
