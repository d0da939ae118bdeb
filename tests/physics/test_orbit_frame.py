"""LVLH and the frame of the docking port, seen from the target's frame, against SciPy."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from rvjax.physics import orbit_frame
from rvjax.physics.dynamics import MU_EARTH
from rvjax.physics.state import TargetMotion
from rvjax.physics.vectors import Vector
from rvjax.simulation import start_frames

Array = NDArray[np.float64]


def vectors(a: Any) -> Vector:
    return Vector(*np.asarray(a, float).T)


@pytest.mark.parametrize("eccentricity", [0.0, 0.3])
def test_the_orbit_frame_is_that_of_its_definition(eccentricity: float) -> None:
    """Axes, rate and the rate's derivative against an orbit and a tumbling target in inertial space, by SciPy: the axes of LVLH
    in T are differentiated numerically. Kills: a sign, −2rᵀv/|r|² left out, ω_o×ω_t left out or swapped, T for LVLH."""
    moments = np.array([400.0, 550.0, 650.0])
    speed = np.sqrt(MU_EARTH * (1.0 + eccentricity) / 6.8e6)

    def slope(t: float, y: Array) -> Array:
        r, v, w, q = y[:3], y[3:6], y[6:9], y[9:]
        wx = np.array([*w, 0.0])
        spin = 0.5 * (q[3] * wx + np.array([*np.cross(q[:3], w), -q[:3] @ w]))
        return np.concatenate([v, -MU_EARTH * r / np.linalg.norm(r) ** 3, -np.cross(w, moments * w) / moments, spin])

    begin = np.array([6.8e6, 0, 0, 0, 0.8 * speed, 0.6 * speed, 0.02, -0.03, 0.01, 0.0, 0.0, 0.0, 1.0])
    h, middle = 0.5, 400.0
    times = middle + h * np.arange(-2, 3)
    y = solve_ivp(slope, (0.0, times[-1]), begin, "DOP853", times, rtol=1e-13, atol=1e-13, max_step=5.0).y.T
    rates, axes = [], []
    for row in y:
        back = Rotation.from_quat(row[9:]).inv()
        target = TargetMotion(vectors(back.apply(row[:3])), vectors(back.apply(row[3:6])), vectors(row[6:9]))
        alpha = vectors(-np.cross(row[6:9], moments * row[6:9]) / moments)
        found = orbit_frame.orbit_axes(target)
        axes.append(np.array([each.parts() for each in (found.a, found.b, found.c)]))
        radial, normal = -row[:3] / np.linalg.norm(row[:3]), -np.cross(row[:3], row[3:6])
        normal /= np.linalg.norm(normal)
        np.testing.assert_allclose(axes[-1], back.apply([np.cross(normal, radial), normal, radial]), atol=1e-12)
        rates.append([np.array(each.parts()) for each in orbit_frame.orbit_turning(target, alpha)])
    weights = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12.0 * h)
    turned = np.einsum("k,kij->ij", weights, axes)
    for row, moved in zip(axes[2], turned, strict=True):
        np.testing.assert_allclose(np.cross(rates[2][0], row), moved, atol=1e-8)
    changed = sum(weight * rate[0] for weight, rate in zip(weights, rates, strict=True))
    np.testing.assert_allclose(rates[2][1], changed, atol=1e-9)


def test_they_are_the_frames_of_a_start() -> None:
    """LVLH and the port's frame are those in which a start is given. Kills: one of the two that is changed alone."""
    generator = np.random.default_rng(5)
    target = TargetMotion(*(vectors(generator.normal(size=3) * size) for size in (7e6, 7e3, 0.01)))
    n = generator.normal(size=3)
    n /= np.linalg.norm(n)
    pairs = (
        (orbit_frame.orbit_axes(target), start_frames.lvlh_axes(target)),
        (orbit_frame.port_axes(vectors(n)), start_frames.port_axes(vectors(n))),
        (orbit_frame.port_axes(vectors(-n)), start_frames.port_axes(vectors(-n))),
    )
    for ours, theirs in pairs:
        for row, other in zip((ours.a, ours.b, ours.c), (theirs.a, theirs.b, theirs.c), strict=True):
            np.testing.assert_allclose(row.parts(), other.parts(), atol=1e-14)


@pytest.mark.parametrize(
    "n", [(1, 0, 0), (0, 1, 0), (0.6, 0, -0.8), (-0.6, 0.8, 0), (-1, 1e-5, -2e-5), (-1, 3e-9, 4e-9), (-1, 0, 0)]
)
def test_the_port_s_frame_is_the_shortest_turn(n: tuple[float, float, float]) -> None:
    """Against SciPy's rotation about x × n; for −x half a turn about z. Kills: a sign, cancellation near −x."""
    axis = np.array(n) / np.linalg.norm(n)
    found = orbit_frame.port_axes(Vector(*map(jnp.asarray, axis)))
    across = np.array([0.0, -axis[2], axis[1]])
    size = np.linalg.norm(across)
    about = across / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
    turn = Rotation.from_rotvec(about * np.arctan2(size, axis[0]))
    rows = np.array([[float(x) for x in row.parts()] for row in (found.a, found.b, found.c)])
    np.testing.assert_allclose(rows, turn.as_matrix().T, atol=1e-12)
