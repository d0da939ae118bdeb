"""Effects against modes and integrations that share no code with them.

appendage   off the centre of mass: modes of two bodies on springs, by a generalised eigenvalue problem; and the same two bodies
            in the inertial frame with all nonlinear terms
pendulum    small oscillations under a constant thrust through the centre of mass

    ω² = (a/l) [1 + m_s/m + (b − l) b m_s/J],   a = F/(m + m_s)           b: pivot, ahead of the centre of mass
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from rvjax.components.effects import slosh_pendulum
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Vector
from tests.physics import test_effects
from tests.physics.test_effects import FORCE, INERTIA, MASS, RATE, TORQUE, Array, flown

MODAL, PLACE = 12.0, np.array([0.9, -0.6, 0.4])


def skew(a: Array) -> Array:
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def by_modes(frequency: Array, duration: float, wrench: Array) -> tuple[Array, Array]:
    """(rate of the body, displacement) of the linear system from rest under a constant wrench, mode by mode.

    T = ½ m|v|² + ½ Ω·JΩ + ½ m_a|v + Ω×r + w|²,  V = ½ m_a |ω y|²."""
    mass = np.zeros((9, 9))
    mass[:3, :3], mass[3:6, 3:6] = MASS * np.eye(3), INERTIA
    moving = np.hstack([np.eye(3), -skew(PLACE), np.eye(3)])
    mass += MODAL * moving.T @ moving
    stiffness = np.zeros((9, 9))
    stiffness[6:, 6:] = MODAL * np.diag(frequency**2)
    squares, modes = eigh(stiffness, mass)  # modesᵀ mass modes = I
    w = np.sqrt(np.maximum(squares, 0.0))
    assert (w[:6] < 1e-5).all(), "six rigid modes"
    given = modes.T @ np.concatenate([wrench, np.zeros(3)])
    safe = np.where(w < 1e-5, 1.0, w)
    amount = np.where(w < 1e-5, 0.5 * duration**2, (1.0 - np.cos(safe * duration)) / safe**2) * given
    speed = np.where(w < 1e-5, duration, np.sin(safe * duration) / safe) * given
    return (modes @ speed)[3:6], (modes @ amount)[6:]


def appendage(frequency: Array) -> Numbers:
    return Numbers({
        "modal_mass_kg": MODAL, "frequency_rad_s": Vector(*frequency), "damping": 0.0, "place_m": Vector(*PLACE)
    })  # fmt: skip


def test_an_appendage_off_the_centre_has_the_modes_of_two_bodies(monkeypatch: pytest.MonkeyPatch) -> None:
    """From rest under a small wrench, after several periods of each mode: all nine coordinates are coupled. Kills: a torque of
    the other sign or about another point, α×r that is left out, a mass ratio for the coupled mass matrix."""
    small = 1e-4
    monkeypatch.setattr(test_effects, "FORCE", FORCE * small)
    monkeypatch.setattr(test_effects, "TORQUE", TORQUE * small)
    frequency = np.array([2.0, 3.1, 1.3])
    omega, (mode,) = flown(["flexible-appendage"], [appendage(frequency)], np.zeros(3), 10.0, 0.005)
    rate, displacement = by_modes(frequency, 10.0, np.concatenate([FORCE, TORQUE]) * small)
    np.testing.assert_allclose(omega, rate, rtol=2e-4, atol=1e-9)
    np.testing.assert_allclose(np.array(mode.displacement.parts()), displacement, rtol=2e-4, atol=1e-9)


def by_springs(frequency: Array, duration: float) -> tuple[Array, Array]:
    """(Ω in the body, displacement) of the body and the mass on springs that turn with it, in the inertial frame, exactly."""

    def slope(t: float, y: Array) -> Array:
        turn, v, w, place, speed = y[3:12].reshape(3, 3), y[12:15], y[15:18], y[18:21], y[21:24]
        inside = turn.T @ (place - y[:3])
        pull = MODAL * frequency**2 * (inside - PLACE)  # on the body, in its frame
        alpha = np.linalg.solve(INERTIA, TORQUE + np.cross(inside, pull) - np.cross(w, INERTIA @ w))
        return np.concatenate([v, (turn @ skew(w)).ravel(), turn @ (FORCE + pull) / MASS, alpha, speed, -turn @ pull / MODAL])

    begin = np.concatenate([np.zeros(3), np.eye(3).ravel(), np.zeros(3), RATE, PLACE, np.cross(RATE, PLACE)])
    end = solve_ivp(slope, (0.0, duration), begin, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    return end[15:18], end[3:12].reshape(3, 3).T @ (end[18:21] - end[:3]) - PLACE


def test_a_stiff_appendage_on_a_turning_body_is_a_mass_on_springs() -> None:
    """Terms of y α, y Ω² and w Ω are left out: with four times the frequency the rate differs from the exact one by 6e-5 in the
    place of 7e-4 rad/s, the displacement by 4 in the place of 7 %. Kills: Ω×(Ω×r) that is left out, a reaction on a body that
    does not turn."""
    apart: list[tuple[float, float]] = []
    for stiff in (1.0, 4.0):
        frequency = np.array([3.0, 4.1, 2.6]) * stiff
        omega, (mode,) = flown(["flexible-appendage"], [appendage(frequency)], RATE, 5.0, 0.0025)
        rate, displacement = by_springs(frequency, 5.0)
        moved = float(np.linalg.norm(displacement))
        apart.append((
            float(np.linalg.norm(omega - rate)), float(np.linalg.norm(np.array(mode.displacement.parts()) - displacement)) / moved
        ))  # fmt: skip
    (soft_rate, soft), (stiff_rate, stiff_share) = apart
    assert soft_rate < 1e-3
    assert stiff_rate < 1e-4
    assert stiff_share < soft < 0.08


@pytest.mark.parametrize("pivot", [0.0, -0.35, 0.5])
def test_a_pendulum_swings_as_its_mode(pivot: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """φ = φ₀ cos ωt for φ₀ = 1e-3, over three periods, with the pivot at, behind and ahead of the centre of mass. Kills: a body
    that does not give way, or does not turn, a tension by the mass of the body alone."""
    thrust, slosh, length, lean = 40.0, 15.0, 0.6, 1e-3
    monkeypatch.setattr(test_effects, "FORCE", np.array([thrust, 0.0, 0.0]))
    monkeypatch.setattr(test_effects, "TORQUE", np.zeros(3))
    monkeypatch.setattr(test_effects, "INERTIA", np.diag([20.0, 24.0, 17.0]))
    rod = length * np.array([-np.cos(lean), -np.sin(lean), 0.0])
    numbers = Numbers({
        "slosh_mass_kg": slosh, "pivot_m": Vector(pivot, 0.0, 0.0), "rod_m": Vector(*rod), "damping": 0.0
    })  # fmt: skip
    accel = thrust / (MASS + slosh)
    square = accel / length * (1.0 + slosh / MASS + (pivot - length) * pivot * slosh / 17.0)
    duration = 3.0 * 2.0 * np.pi / np.sqrt(square)
    for share in (0.9, 1.0):
        step = 0.01
        steps = round(share * duration / step)
        _, states = flown(["slosh-pendulum"], [numbers], np.zeros(3), steps * step, step)
        pendulum: Any = slosh_pendulum.unit(states[0])
        expected = lean * np.cos(np.sqrt(square) * steps * step)
        assert float(-pendulum.direction.y) == pytest.approx(expected, abs=2e-3 * lean)
