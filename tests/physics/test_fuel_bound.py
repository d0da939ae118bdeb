"""The lower bound on Δv: against a linear program over impulses, against transfers known in closed form, and in flights."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from rvjax.physics import primer
from rvjax.physics.free_motion import FreeMotion
from tests.chosen import flown, folded, step, vector

Array = NDArray[np.float64]
MU = 3.986004418e14
lower_bound = jax.jit(primer.lower_bound)


def bound(begin: Array, end: Array, time: float) -> float:
    """begin, end: rows r, v, Δ, Δ̇."""
    return float(lower_bound(FreeMotion(*map(vector, begin)), FreeMotion(*map(vector, end)), jnp.asarray(time, float)))


def transitions(r: Array, v: Array, times: Array) -> tuple[Array, Array]:
    """((n, 6) orbit, (n, 6, 6) transition matrices of the linearised relative motion from the first time), by DOP853."""

    def rate(_: float, y: Array) -> Array:
        place, phi = y[:3], y[6:].reshape(6, 6)
        d = np.linalg.norm(place)
        gradient = MU / d**3 * (3.0 * np.outer(place, place) / d**2 - np.eye(3))
        slope = np.vstack([phi[3:], gradient @ phi[:3]])
        return np.concatenate([y[3:6], -MU * place / d**3, slope.ravel()])

    y = np.concatenate([r, v, np.eye(6).ravel()])
    solution = solve_ivp(rate, (times[0], times[-1]), y, "DOP853", times, rtol=1e-11, atol=1e-11)
    return solution.y[:6].T, solution.y[6:].T.reshape(-1, 6, 6)


def least(b: Array, phis: Array) -> float:
    """Smallest Σ |Δv| of impulses at the times of the transition matrices that make the change b of the state at the end.

    Dual: the largest cᵀb with |Pᵢᵀc| ≤ 1 at each time, by linear programs with more and more of its tangent planes.
    """
    columns = [(phis[-1] @ np.linalg.inv(phi))[:, 3:] for phi in phis]
    scale = np.array([1.0, 1.0, 1.0, 1e3, 1e3, 1e3])
    planes = [scale * (p @ d) for p in columns for d in (*np.eye(3), *-np.eye(3))]
    while True:
        c = scale * linprog(-(scale * b), np.array(planes), np.ones(len(planes)), bounds=(None, None), method="highs").x
        primers = [p.T @ c for p in columns]
        sizes = np.linalg.norm(primers, axis=1)
        if sizes.max() < 1.0 + 1e-6:
            return float(c @ b)
        planes += [scale * (columns[i] @ primers[i] / sizes[i]) for i in np.flatnonzero(sizes > 1.0 + 1e-7)]


TURNS = Rotation.from_rotvec([[0.3, -1.2, 0.7], [-2.0, 0.4, 1.1]])


@pytest.mark.parametrize(("eccentricity", "time"), [(0.0, 300.0), (0.0, 4000.0), (0.0, 16000.0), (0.3, 1000.0), (0.3, 9000.0)])
def test_it_lies_just_below_the_best_impulses(eccentricity: float, time: float) -> None:
    """The best of 385 impulses, of random transfers; begin and end are given in other axes. The bound is at most that, and at
    least 0.97 of it.

    Kills: ṗᵀΔ with the wrong sign or in seconds, the end in the axes of the begin, gravity's gradient of the wrong sign, the
    orbit that does not move, out-of-plane motion left out, Newton steps uphill.
    """
    chance = np.random.default_rng(int(time))
    perigee = 6.8e6
    r, v = np.array([perigee, 0.0, 0.0]), np.array([0.0, np.sqrt(MU * (1.0 + eccentricity) / perigee), 0.0])
    orbit, phis = transitions(r, v, np.linspace(0.0, time, 385))
    for _ in range(2):
        x = np.concatenate([chance.normal(size=3) * 100.0, chance.normal(size=3) * 0.1])
        y = np.concatenate([chance.normal(size=3) * 5.0, chance.normal(size=3) * 0.02])
        best = least(y - phis[-1] @ x, phis)
        begin = TURNS[0].apply([r, v, x[:3], x[3:]])
        end = TURNS[1].apply([orbit[-1, :3], orbit[-1, 3:], y[:3], y[3:]])
        assert 0.97 * best <= bound(begin, end, time) <= best * (1.0 + 1e-5)


@pytest.mark.parametrize("time", [100.0, 3000.0])
def test_without_gravity_it_is_twice_the_distance_over_the_time(time: float) -> None:
    """From rest to rest over d in the time T: 2d/T, half at the start and half at the end. Far from the Earth nothing else acts.

    Kills: a bound per second of T, a weight of the grid."""
    far = np.array([1e12, 0.0, 0.0]), np.array([0.0, np.sqrt(MU / 1e12), 0.0])
    d = np.array([30.0, -40.0, 120.0])
    assert bound(np.array([*far, d, 0 * d]), np.array([*far, 0 * d, 0 * d]), time) == pytest.approx(260.0 / time, rel=1e-6)


def test_an_impulse_between_two_points_of_the_grid_is_not_dearer_than_it_is() -> None:
    """The change that an impulse of 1 m/s across the orbit makes at its best time costs 1 m/s. Kills: the largest |p| of the grid
    without the allowance for what lies between its points."""
    a, time = 7e6, 20_000.0
    n, spacing = np.sqrt(MU / 7e6**3), 20_000.0 / primer.NODES
    for part in (0.25, 0.5):
        at = (40 + part) * spacing
        late = n * (time - at)
        turn = n * time
        begin = np.array([[a, 0, 0], [0, a * n, 0], [0, 0, 0], [0, 0, 0]])
        end = [[a * np.cos(turn), a * np.sin(turn), 0], [-a * n * np.sin(turn), a * n * np.cos(turn), 0]]
        change = [[0, 0, np.sin(late) / n], [0, 0, np.cos(late)]]
        assert 0.96 < bound(begin, np.array(end + change), time) <= 1.0


def test_nothing_to_do_costs_nothing() -> None:
    """Kills: NaN of 0/0, which no table should have."""
    orbit = [[7e6, 0, 0], [0, 7.5e3, 0]]
    assert bound(np.array(orbit + [[0, 0, 0]] * 2), np.array(orbit + [[0, 0, 0]] * 2), 10.0) == 0.0


def test_the_end_is_the_docking_point_with_its_velocity() -> None:
    """From the docking point of a target that turns to where the docking point is later, hardly any gravity: the pursuer leaves
    with the port's speed then and arrives with that of now. Folded from steps, with
    Δv = ∫ (|f_x| + |f_y| + |f_z|)/m dt.

    Kills: an end at rest, the start of the last step, Δv of another definition than that of every campaign.
    """
    w, port, time = np.array([0.0, 0.0, 0.05]), np.array([5.0, 0.0, 0.0]), 10.0
    turn = Rotation.from_rotvec(w * time)
    r, v = np.array([1e9, 0.0, 0.0]), np.array([0.0, 600.0, 0.0])
    last = turn.inv()  # into T at the end, which has turned
    begin = np.array([r, v, port, np.cross(w, port)])
    end = np.array([last.apply(r + v * time), last.apply(v), port, np.cross(w, port)])
    first = step(0.0, (0, 0, 0), r=r, v=v, w=w, force=(2.0, 0, 0))
    middle = step(5.0, (3, 2, 1), nu=(1, 2, 3), r=r, v=v, w=w, force=(0, -3.0, 4.0))
    final = step(10.0, (1, 0, 0), nu=(1, 0, 0), r=end[0], v=end[1], w=w, force=(0, 3.0, 0))
    values = folded("fuel-bound", [first, middle, final], h=5.0)
    assert values["fuel_bound_m_s"] == pytest.approx(bound(begin, end, time), rel=1e-9)
    chord = turn.apply(port) - port
    speeds = chord / time - np.cross(w, port), turn.apply(np.cross(w, port)) - chord / time
    assert values["fuel_bound_m_s"] == pytest.approx(sum(map(np.linalg.norm, speeds)), rel=1e-3)
    used = 5.0 * (0.5 * 2.0 + 7.0 + 0.5 * 3.0) / 100.0
    assert values["fuel_over_bound"] == pytest.approx(used / values["fuel_bound_m_s"], rel=1e-9)


CAMPAIGN = """
rvjax: 1
name: fuel
samples: 32
seed: 7
horizon: {duration_s: {duration}, step_s: 0.1}
target: {orbit: {semi_major_axis_km: 7000}, rate_deg_s: [0.2, -0.3, 0.4], port_m: [4, -2, 1.5]}
pursuer: {mass_kg: 100, inertia_kgm2: {moments: [22, 20, 23]}}
start: {rho_m: {box: 20}, nu_m_s: {box: 0.1}, sigma: {box: 0.2}, omega_rad_s: {box: 0.01}}
actuators: {upper: 4, lower: 3}
controller: {use: pd-plus}
capture: {window_s: 5}
metrics: [{use: fuel-bound}]
"""


def test_no_flight_that_arrives_uses_less(tmp_path: Path) -> None:
    """32 flights of 240 s that end at the port. Kills: a bound on another transfer: one that begins at the last step."""
    flight: Any = flown(tmp_path / "campaign.yaml", CAMPAIGN.replace("{duration}", "240"), 32)
    values = flight.values
    assert (values["final_position_error_m"] < 0.05).all()
    used = np.trapezoid(np.abs(flight.force).sum(axis=2), flight.t, axis=1) / 100.0
    np.testing.assert_allclose(values["fuel_over_bound"], used / values["fuel_bound_m_s"], rtol=1e-9)
    assert (values["fuel_over_bound"] > 1.0).all()
    assert np.ptp(values["fuel_bound_m_s"]) > 0.1
