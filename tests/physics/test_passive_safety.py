"""Free drift: against both absolute orbits in SciPy, Clohessy and Wiltshire's equations, and the trace of a flight."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.chosen import Array, Flight, flown, folded, step

MU = 3.986004418e14


def drift(r: Array, v: Array, delta: Array, speed: Array, horizon_s: float, points: int = 20_001) -> Array:
    """(points,) distances of two free bodies, each on its orbit about the Earth, by DOP853."""

    def rate(_: float, y: Array) -> Array:
        pull = [-MU * y[i : i + 3] / np.linalg.norm(y[i : i + 3]) ** 3 for i in (0, 6)]
        return np.concatenate([y[3:6], pull[0], y[9:12], pull[1]])

    y = np.concatenate([r, v, r + delta, v + speed])
    times = np.linspace(0.0, horizon_s, points)
    solution = solve_ivp(rate, (0.0, horizon_s), y, "DOP853", times, rtol=1e-12, atol=1e-9)
    return np.linalg.norm(solution.y[6:9] - solution.y[:3], axis=0)


def relative_step(r: Any, v: Any, delta: Any, speed: Any, t: float = 0.0) -> Any:
    """A step with this motion relative to the target [m, m/s]; the pursuer is turned and the target tumbles."""
    sigma, w = (0.2, -0.3, 0.1), (1e-3, -2e-3, 3e-3)
    into = Rotation.from_mrp(sigma).inv()  # T to P
    port = np.array([5.0, 0.0, 0.0])
    rho, nu = into.apply(np.asarray(delta) - port), into.apply(np.asarray(speed) - np.cross(w, port))
    return step(t, rho, nu, sigma, r=r, v=v, w=w)


def clearance(first: Any, radius: float, horizon_s: float = 5400.0, **said: Any) -> float:
    """Of a flight of one step."""
    return folded("passive-safety", [first], radius_m=radius, coast_s=horizon_s, **said)["free_drift_clearance_m"]


@pytest.mark.parametrize("eccentricity", [0.0, 0.1])
def test_a_drift_is_that_of_two_absolute_orbits(eccentricity: float) -> None:
    """Starts near and far, at rest and fast, followed for an orbit and a half: within 1e-5 of the largest distance of the drift.

    Kills: the velocity in the turning frame, gravity without its gradient, a minimum at the steps of the drift only, a drift
    half as long, R for Rᵀ.
    """
    chance = np.random.default_rng(3)
    perigee = 6.8e6
    r, v = np.array([perigee, 0.0, 0.0]), np.array([0.0, np.sqrt(MU * (1.0 + eccentricity) / perigee), 0.0])
    nearer = 0
    for _ in range(6):
        delta = chance.normal(size=3) * 100.0
        speed = -delta / 600.0 + chance.normal(size=3) * 0.03
        distances = drift(r, v, delta, speed, 8000.0)
        found = clearance(relative_step(r, v, delta, speed), 1.0, 8000.0) + 1.0
        assert found == pytest.approx(distances.min(), abs=1e-5 * distances.max() + 1e-3)
        nearer += distances[0] > 2.0 * distances.min()
    assert nearer >= 4, "most of them come nearer than they start"


def clohessy_wiltshire(x: Array, u: Array, n: float, t: Array) -> Array:
    """(points,) distance; x, y, z: outward, along the velocity, across the orbit (W. Clohessy, R. Wiltshire, 1960)."""
    s, c = np.sin(n * t), np.cos(n * t)
    place = (
        (4 - 3 * c) * x[0] + s / n * u[0] + 2 / n * (1 - c) * u[1],
        6 * (s - n * t) * x[0] + x[1] + 2 / n * (c - 1) * u[0] + (4 * s / n - 3 * t) * u[1],
        c * x[2] + s / n * u[2],
    )
    return np.sqrt(sum(part**2 for part in place))


POINTS = {
    "at rest on the V-bar": ((0, 250, 0), (0, 0, 0), True),
    "at rest below, on the R-bar": ((-250, 0, 0), (0, 0, 0), True),
    "at rest ahead and 20 m too high: it falls back over the target": ((20, 600, 0), (0, 0, 0), False),
    "along the V-bar at 40 cm/s": ((0, 250, 0), (0, -0.4, 0), False),
    "along the V-bar at 1 cm/s: it hops away": ((0, 1000, 0), (0, -0.01, 0), True),
    "up the R-bar at 20 cm/s: it drifts ahead": ((-250, 0, 0), (0.2, 0, 0), True),
    "across the orbit, no drift: it swings through": ((0, 0, 250), (0, 0, 0), False),
}


@pytest.mark.parametrize("name", POINTS)
def test_hold_points_as_in_the_linear_equations(name: str) -> None:
    """Kills: ω_t×Δ with the wrong sign, a ball about the port, a horizon in steps."""
    x, u, safe = (np.array(part, float) if i < 2 else part for i, part in enumerate(POINTS[name]))
    a, radius = 7.0e6, 200.0
    n = np.sqrt(MU / a**3)
    r, v = np.array([a, 0, 0]), np.array([0, a * n, 0])
    expected = clohessy_wiltshire(x, u, n, np.linspace(0.0, 5400.0, 20_001)).min() - radius
    found = clearance(relative_step(r, v, x, u + np.cross([0, 0, n], x)), radius)
    assert found == pytest.approx(expected, abs=1.0)
    assert (found > 0.0) == safe


@pytest.mark.parametrize("horizon_s", [30.0, 100.0, 180.0])
def test_the_drift_ends_at_its_horizon(horizon_s: float) -> None:
    """Towards the target, nearest at the end. Kills: a step of the drift too few or too many, steps of another length."""
    a, x = 7.0e6, np.array([0.0, 250.0, 0.0])
    n = np.sqrt(MU / a**3)
    r, v, speed = np.array([a, 0, 0]), np.array([0, a * n, 0]), np.array([0, -0.4, 0]) + np.cross([0, 0, n], x)
    expected = drift(r, v, x, speed, horizon_s)
    assert expected.argmin() == len(expected) - 1
    assert clearance(relative_step(r, v, x, speed), 10.0, horizon_s) == pytest.approx(expected[-1] - 10.0, abs=1e-3)


def test_only_instants_outside_the_ball_and_after_the_fault_count() -> None:
    """Kills: an instant inside, one before the onset, one without any fault, time beyond the end of the flight."""
    a, n = 7.0e6, np.sqrt(MU / 7.0e6**3)

    def at(t: float, x: float, speed: float) -> Any:
        return relative_step((a, 0, 0), (0, a * n, 0), (0, x, 0), np.array([0, speed, 0]) + np.cross([0, 0, n], [0, x, 0]), t=t)

    way = [at(0.0, 300, -1.0), at(20.0, 260, 0.0), at(40.0, 230, -1.0), at(60.0, 150, -1.0), at(75.0, 210, -1.0)]
    said = {"radius_m": 200.0, "coast_s": 600.0, "every_s": 20.0, "drift_step_s": 10.0}
    values = folded("passive-safety", way, h=20.0, **said)
    assert values["free_drift_unsafe_s"] == pytest.approx(40.0)  # at 0 and 40 s; at 75 s nothing is left
    assert values["free_drift_clearance_m"] < -150.0
    later = folded("passive-safety", way[1:3], onset_s=20.0, **{**said, "from": "fault"})
    assert later["free_drift_unsafe_s"] == pytest.approx(0.0)
    assert later["free_drift_clearance_m"] < -140.0
    before = folded("passive-safety", way[:2], onset_s=15.0, **{**said, "from": "fault"})
    assert before["free_drift_clearance_m"] == pytest.approx(60.0, abs=0.1)
    never = folded("passive-safety", way, **{**said, "from": "fault"})
    assert never == {"free_drift_clearance_m": np.inf, "free_drift_unsafe_s": 0.0}


CAMPAIGN = """
rvjax: 1
name: drift
samples: 3
seed: 7
engine: {engine}
horizon: {duration_s: 21, step_s: 0.1}
target: {orbit: {semi_major_axis_km: 7000}, rate_deg_s: [0.2, -0.3, 0.4], port_m: [4, -2, 1.5]}
pursuer: {mass_kg: 100, inertia_kgm2: {moments: [22, 20, 23]}}
start: {rho_m: [{uniform: [14, 16]}, 1, 2], nu_m_s: [-0.4, 0.1, 0], sigma: {box: 0.2}, omega_rad_s: {box: 0.02}}
actuators: {upper: 4, lower: 3}
faults: [{use: effectiveness, onset_s: {uniform: [4, 14]}, remaining: 0.5, channels: [fx]}]
controller: {use: pd-plus}
capture: {window_s: 5}
metrics:
  - {use: passive-safety, radius_m: {uniform: [12, 13]}, coast_s: 600, every_s: 3, drift_step_s: 10}
  - {use: passive-safety, name: late, radius_m: 10, coast_s: 600, every_s: 2, drift_step_s: 10, from: fault}
"""


def of_the_trace(flight: Flight, lane: int, every: int, radius: float, first_s: float) -> tuple[float, float]:
    """(clearance, unsafe time), by two absolute orbits from every `every`-th row that counts."""
    smallest, unsafe = np.inf, 0.0
    port = np.array([float(part[lane]) for part in flight.drawn.plant.port.parts()])
    for k in range(0, len(flight.t), every):
        back = Rotation.from_mrp(flight.sigma[lane, k])
        delta = back.apply(flight.rho[lane, k]) + port
        speed = back.apply(flight.nu[lane, k]) + np.cross(flight.w[lane, k], port)
        if np.linalg.norm(delta) <= radius or flight.t[k] < first_s:
            continue
        left = drift(flight.r[lane, k], flight.v[lane, k], delta, speed, 600.0).min() - radius
        smallest = min(smallest, left)
        unsafe += min(0.1 * every, flight.t[-1] - flight.t[k]) if left < 0.0 else 0.0
    return smallest, unsafe


@pytest.mark.parametrize("engine", ["llvm", "xla"])
def test_a_flight_is_looked_at_at_its_instants(engine: str, tmp_path: Path) -> None:
    """Kills: every step instead of every instant, instants that are off by a step, the numbers of the other metric, an instant
    that stands for too long."""
    flight = flown(tmp_path / "campaign.yaml", CAMPAIGN.replace("{engine}", engine), 3)
    onset = flight.drawn.context.last_onset_s
    for lane in range(3):
        radius = float(flight.drawn.context.chosen[0]["radius_m"][lane])
        for prefix, expected in (
            ("", of_the_trace(flight, lane, 30, radius, 0.0)),
            ("late_", of_the_trace(flight, lane, 20, 10.0, float(onset[lane]))),
        ):
            names = (f"{prefix}free_drift_clearance_m", f"{prefix}free_drift_unsafe_s")
            assert [float(flight.values[name][lane]) for name in names] == pytest.approx(expected, abs=1e-3)
    assert np.ptp(flight.values["late_free_drift_unsafe_s"]) > 0.0


def test_another_step_is_another_program(tmp_path: Path) -> None:
    """The same campaign with a step twice as long has half as many steps between two instants. Kills: a compiled program that is
    shared by campaigns of different steps."""
    flights = [
        flown(tmp_path / f"{h}.yaml", CAMPAIGN.replace("{engine}", "llvm").replace("step_s: 0.1", f"step_s: {h}"), 2)
        for h in (0.1, 0.5)
    ]
    values = [flight.values["free_drift_unsafe_s"] for flight in flights]
    np.testing.assert_allclose(values[0], values[1], atol=1e-6)
