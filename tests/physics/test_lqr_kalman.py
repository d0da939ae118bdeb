"""The discrete-time baseline: its gains against SciPy's Riccati solver, its estimate and its flights."""

from __future__ import annotations

from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from rvjax.execution.replay import replay
from rvjax.execution.run import run
from rvjax.physics.riccati import filtered, regulator
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN, SHORT

PERIOD = 0.5
A, B = np.array([[1.0, PERIOD], [0.0, 1.0]]), np.array([[0.5 * PERIOD**2], [PERIOD]])


@pytest.mark.parametrize("weights", [(1.0, 0.035, 0.0025), (1.0, 0.14, 0.04), (0.01, 1.0, 10.0)])
def test_the_regulator_solves_the_riccati_equation(weights: tuple[float, float, float]) -> None:
    """Against SciPy. Kills: weights that are not inverted, too few doublings, the continuous gain."""
    error, speed, effort = weights
    s = solve_discrete_are(A, B, np.diag([error**-2, speed**-2]), np.array([[effort**-2]]))
    expected = np.linalg.solve(effort**-2 + B.T @ s @ B, B.T @ s @ A)[0]
    np.testing.assert_allclose(regulator(PERIOD, *map(jnp.asarray, weights)), expected, rtol=1e-9)


@pytest.mark.parametrize("noise", [(0.01, 0.002, 0.005), (1e-3, 2e-4, 0.005), (1.0, 1.0, 1e-3)])
def test_the_filter_solves_the_riccati_equation(noise: tuple[float, float, float]) -> None:
    """Against SciPy, by duality. Kills: standard deviations for variances, the gain of the predictor."""
    sensor, speed, unknown = noise
    n = np.diag([sensor**2, speed**2])
    p = solve_discrete_are(A.T, np.eye(2), B @ B.T * unknown**2, n)
    np.testing.assert_allclose(filtered(PERIOD, *map(jnp.asarray, noise)), p @ np.linalg.inv(p + n), rtol=1e-8)


@pytest.mark.usefixtures("bare")
def test_its_prediction_is_what_comes(tmp_path: Path) -> None:
    """Known mass and inertia, no disturbance or fault, no saturation: the position expected at the next instant is that of the
    flight to the square of the turn in a period, and it comes closer as (1 + kt)e^{−kt}. Kills: a frame that does not turn, an
    acceleration with the wrong sign, a prediction for another instant."""
    sets = [
        *SHORT[:3], "faults=[]", "disturbances=[]", "controller={use: lqr-kalman}", "samples=4", "pursuer.mass_kg=100",
        "pursuer.inertia_kgm2={principal: [21.7, 21.7, 21.7]}", "actuators={upper: 100, lower: 100}", "horizon.duration_s=40",
        "correlate=[]", "start.rho_m={box: 5}",
    ]  # fmt: skip
    folder = run(CAMPAIGN, tmp_path / "run", sets, progress=False)
    trace, _, _ = replay(folder, 1)
    step = round(PERIOD / (trace["t_s"][1] - trace["t_s"][0]))
    names = [f"rho_{axis}_m" for axis in "xyz"]
    expected = trace[[f"ctl.expected_rho_m_{axis}" for axis in "xyz"]].to_numpy()[:-step:step]
    there = trace[names].to_numpy()[step::step]
    assert np.max(np.abs(there[1:])) > 1.0
    np.testing.assert_allclose(expected, there[: len(expected)], atol=2e-3)
    assert np.linalg.norm(there[-1]) < 0.6 * np.linalg.norm(there[0])


def test_its_signals_are_known_to_margins() -> None:
    """A margin may name them. Kills: signals that are looked for in a continuous controller only."""
    margins = "margins={near: {always: {signal: ctl.expected_rho_m_x, below: 100}}}"
    assert load(CAMPAIGN, ["controller={use: lqr-kalman}", "correlate=[]", margins]).margins
