"""Propellant: the mass balance, Tsiolkovsky's equation, the body that is left, a tumbling flight, against NumPy and SciPy alone.

The pursuers of these tests are made of point masses, so their mass, centre and inertia with and without propellant are sums.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp, trapezoid
from scipy.spatial.transform import Rotation

from rvjax.columns import CHANNELS
from rvjax.components.controllers.interface import Controller, Response
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.effects.interface import Body, Effect
from rvjax.components.registry import standard_metrics
from rvjax.physics.propellant import Propellant, lighter
from rvjax.physics.state import Measurement, Numbers, Plant, Report, Tick
from rvjax.physics.vectors import Channels, Symmetric, Vector
from rvjax.simulation import closed_loop
from rvjax.simulation.batch import Flyer
from rvjax.simulation.closed_loop import Drawn, Loop
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines.llvm.engine import LlvmEngine
from rvjax.simulation.problem import load
from rvjax.simulation.tables import trace_tables
from tests import flights
from tests.oracles.absolute import columns
from tests.short import CAMPAIGN, SHIPPED

Array = NDArray[np.float64]

G0 = 9.80665
FAR_M = 1e13
"""Distance from the Earth's centre at which gravity is 4e-12 m/s²: free space."""

STEP_S, DURATION_S = 0.05, 50.0
LIMIT = 50.0

GENERATOR = np.random.default_rng(20181)
PLACES = GENERATOR.uniform(-0.8, 0.9, (9, 3))
MASSES = GENERATOR.uniform(5.0, 12.0, 9)
TANK, FULL = np.array([0.3, -0.25, 0.4]), 20.0
DRY = float(MASSES.sum())


def body(left: float) -> tuple[float, Array, Array]:
    """(mass, centre, inertia about it) of the point masses and of what is left in the tank, by sums."""
    masses, places = np.append(MASSES, left), np.vstack([PLACES, TANK])
    mass = masses.sum()
    centre = masses @ places / mass
    arms = places - centre
    return mass, centre, np.einsum("n,nij->ij", masses, [a @ a * np.eye(3) - np.outer(a, a) for a in arms])


def plant(left: float) -> Plant:
    """The same as the plant of a flight."""
    mass, centre, inertia = body(left)
    back = np.linalg.inv(inertia)
    moments, inverse = (
        Symmetric(*(j[i, k] for i, k in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)))) for j in (inertia, back)
    )
    most, zero = Channels.of((LIMIT,) * 6), Vector(0.0, 0.0, 0.0)
    target = Symmetric.of(500.0, 0.0), Symmetric.of(1.0 / 500.0, 0.0)
    return Plant(mass, moments, inverse, most, most, *target, zero, Vector(*centre))


def matrix(j: Symmetric) -> Array:
    return np.array(flights.matrix(j), dtype=float)


@pytest.mark.parametrize("used", [0.0, 1e-3, 7.0, FULL])
def test_what_is_left_is_that_of_its_point_masses(used: float) -> None:
    """Mass, centre of mass, inertia about it and its inverse; at t = 0 the campaign's own numbers, bit for bit. Kills: a centre
    that moves toward the tank, a transfer that forgets that the centre moves, the inertia at t = 0, its inverse at t = 0."""
    full = plant(FULL)
    found = lighter(full, Propellant(FULL, 200.0, Vector(*TANK)), used)
    mass, centre, inertia = body(FULL - used)
    np.testing.assert_allclose(found.mass, mass, rtol=1e-14)
    np.testing.assert_allclose(found.centre.parts(), centre, rtol=1e-11)
    np.testing.assert_allclose(matrix(found.inertia), inertia, rtol=1e-12)
    np.testing.assert_allclose(matrix(found.inertia_inverse), np.linalg.inv(inertia), rtol=1e-11)
    if not used:
        assert (found.mass, found.centre, found.inertia) == (full.mass, full.centre, full.inertia)


SWAY = np.array([0.11, 0.07, 0.13, 0.05, 0.09, 0.06])
"""Angular frequencies of the command [rad/s]."""


def start(measurement: Measurement, gains: Numbers) -> tuple[()]:
    del measurement, gains
    return ()


def respond(measurement: Measurement, state: tuple[()], saturate: Any, gains: Numbers) -> Response:
    """mean + swing sin(w t) on each channel."""
    del saturate
    parts = zip(gains["mean"].parts(), gains["swing"].parts(), SWAY, strict=True)
    command = Channels.of(tuple(mean + swing * jnp.sin(w * measurement.t) for mean, swing, w in parts))
    zero = Channels.of((measurement.t * 0.0,) * 6)
    return Response(command, state, Report(zero, measurement.t * 0.0, {}))


def scene(mean: Array, swing: Array, omega: Array, propellant: Propellant) -> Drawn:
    """A sample in free space: σ = 0, the target at rest."""
    drawn = flights.lane(flights.draw({}, DURATION_S, STEP_S, lanes=1), 0)
    zero = Vector(0.0, 0.0, 0.0)
    gains = Numbers({"mean": Channels.of(tuple(mean)), "swing": Channels.of(tuple(swing))})
    return drawn._replace(
        plant=plant(FULL),
        motion=drawn.motion._replace(rho=zero, nu=zero, sigma=zero, omega=Vector(*omega)),
        target=drawn.target._replace(r=Vector(FAR_M, 0.0, 0.0), v=zero, w=zero),
        faults=(),
        disturbances=(),
        gains=gains,
        propellant=propellant,
    )


@cache
def flyer() -> Flyer:
    """Of the scene."""
    loop = Loop(Controller(start, respond), flights.SATURATIONS["hard-clip"], (), ())
    return Flyer(LlvmEngine(loop, standard_metrics(lambda place: place == "pursuer.propellant")))


def flown(drawn: Drawn) -> tuple[pd.DataFrame, dict[str, float]]:
    """The trace with every step, and the metrics."""
    lanes = jax.tree.map(lambda x: np.atleast_1d(np.asarray(x, float)), drawn)
    found = flyer().fly(lanes, round(DURATION_S / STEP_S), 1, trace=[0])
    (trace,), _ = trace_tables(found.steps, {}, False, means=found.means)
    return trace, {name: float(x[0]) for name, x in found.values.items()}


def test_tsiolkovsky() -> None:
    """A constant thrust through the centre of mass in free space: Δv = I_sp g₀ ln(m₀/m). RK4 is Simpson's rule here: its error
    of 1e-20 m/s is below rounding. That of the metric's trapezoidal rule is h²/12 (da/dt at T − at 0) = 1e-7 m/s. Kills: a
    specific impulse that is forgotten, another g₀, the mass at t = 0 in the acceleration or in the metric."""
    zero = Vector(0.0, 0.0, 0.0)
    mean = np.array([40.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    drawn = scene(mean, mean * 0.0, np.zeros(3), Propellant(FULL, 15.0, zero))
    drawn = drawn._replace(plant=drawn.plant._replace(centre=zero))
    trace, values = flown(drawn)
    mass = DRY + FULL - 40.0 * DURATION_S / (15.0 * G0)
    assert mass < 0.88 * (DRY + FULL), "much is burnt"
    expected = 15.0 * G0 * np.log((DRY + FULL) / mass)
    last = trace.iloc[-1]
    assert last["mass_kg"] == pytest.approx(mass, rel=1e-12)
    assert last["nu_x_m_s"] == pytest.approx(expected, rel=1e-12)
    jerk = 40.0**2 / (15.0 * G0) * (1.0 / mass**2 - 1.0 / (DRY + FULL) ** 2)
    assert values["delta_v_m_s"] == pytest.approx(expected + STEP_S**2 / 12.0 * jerk, abs=1e-10)
    assert values["thrust_impulse_Ns"] == pytest.approx(40.0 * DURATION_S, rel=1e-12)
    assert values["propellant_used_kg"] == pytest.approx(DRY + FULL - mass, rel=1e-11)
    assert values["propellant_left_kg"] == pytest.approx(mass - DRY, rel=1e-11)


def by_scipy(mean: Array, swing: Array, omega: Array, specific_impulse: float, arm: float) -> Array:
    """(x, v, C, Ω, m_c) at the end: the equations of variable mass in inertial axes, the body a sum of point masses."""

    def slope(t: float, y: Array) -> Array:
        turn, spin = y[6:15].reshape(3, 3), y[15:18]
        wrench = mean + swing * np.sin(SWAY * t)
        mass, centre, inertia = body(FULL - y[18])
        moment = wrench[3:] - np.cross(centre, wrench[:3])
        skew = np.array([[0, -spin[2], spin[1]], [spin[2], 0, -spin[0]], [-spin[1], spin[0], 0]])
        alpha = np.linalg.solve(inertia, moment - np.cross(spin, inertia @ spin))
        burnt = (np.abs(wrench[:3]).sum() + np.abs(wrench[3:]).sum() / arm) / (specific_impulse * G0)
        return np.concatenate([y[3:6], turn @ wrench[:3] / mass, (turn @ skew).ravel(), alpha, [burnt]])

    begin = np.concatenate([np.zeros(6), np.eye(3).ravel(), omega, [0.0]])
    return solve_ivp(slope, (0.0, DURATION_S), begin, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


def test_a_tumbling_flight_is_that_of_scipy() -> None:
    """Forces and torques on all axes, a tank off the centre of mass, 3.5 kg of 100 burnt. The difference is RK4's: 2.8e-7 m and
    5e-10 rad/s, a sixteenth of that with half the step. Kills: a moment about the centre of mass at t = 0, the inertia at t = 0,
    torques that burn nothing in spite of their arm, an arm that multiplies."""
    mean, swing = np.array([0.8, 0.5, 0.6, 0.04, 0.05, 0.03]), np.array([0.3, -0.2, 0.25, 0.02, -0.02, 0.01])
    omega = np.array([0.1, -0.15, 0.2])
    trace, values = flown(scene(mean, swing, omega, Propellant(FULL, 3.0, Vector(*TANK), 0.5)))
    end = by_scipy(mean, swing, omega, 3.0, 0.5)
    turn, last = end[6:15].reshape(3, 3), trace.iloc[-1:]
    assert 3.0 < end[18] < 4.0
    assert values["propellant_used_kg"] == pytest.approx(end[18], rel=1e-9)
    np.testing.assert_allclose(columns(last, "rho_*_m")[0], turn.T @ end[:3], atol=6e-7)
    np.testing.assert_allclose(columns(last, "nu_*_m_s")[0], turn.T @ end[3:6], atol=2e-8)
    np.testing.assert_allclose(columns(last, "omega_*_rad_s")[0], end[15:18], atol=2e-9)
    between = Rotation.from_mrp(columns(last, "sigma_*")[0]).as_matrix().T @ turn
    assert Rotation.from_matrix(between).magnitude() < 1e-8
    mass, centre, _ = body(FULL - end[18])
    assert float(last["mass_kg"].iloc[0]) == pytest.approx(mass, rel=1e-11)
    np.testing.assert_allclose(columns(last, "centre_of_mass_*_m")[0], centre, rtol=1e-9)


@pytest.mark.parametrize("arm", [(), 0.5])
def test_with_an_empty_tank_forces_end(arm: Any) -> None:
    """10 kg are gone after 29 s. Torques end too where they burn propellant. Kills: a tank that never empties, a thrust that ends
    a step too early or too late, a mass below that of the empty body, torques of wheels that end."""
    mean = np.array([40.0, -10.0, 0.0, 0.1, 0.0, 0.0])
    trace, values = flown(scene(mean, mean * 0.0, np.zeros(3), Propellant(10.0, 15.0, Vector(*TANK), arm)))
    rate = (50.0 + (0.1 / 0.5 if arm else 0.0)) / (15.0 * G0)
    empty = trace["t_s"].to_numpy() >= 10.0 / rate
    applied = columns(trace, "applied_*", CHANNELS)
    np.testing.assert_array_equal(applied[~empty], np.broadcast_to(mean, applied[~empty].shape))
    assert 0.2 < empty.mean() < 0.8
    assert not applied[empty, :3].any()
    assert (applied[empty, 3] == (0.0 if arm else 0.1)).all()
    assert (trace["propellant_left_kg"][empty] == 0.0).all()
    assert (trace["propellant_left_kg"][~empty] > 0.0).all()
    assert (values["propellant_used_kg"], values["propellant_left_kg"]) == (10.0, 0.0)
    np.testing.assert_allclose(trace["mass_kg"][empty], DRY + FULL - 10.0, rtol=1e-15)


def test_the_last_thrust_lasts_to_the_end_of_its_step() -> None:
    """Δv of a straight flight: Tsiolkovsky's up to the empty tank, F/m from there to the end of the step. The mass bends within
    the step, which costs RK4 less than h F δm/m² = 4e-6 m/s. Kills: a thrust that ends between two stages."""
    zero = Vector(0.0, 0.0, 0.0)
    mean = np.array([40.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    drawn = scene(mean, mean * 0.0, np.zeros(3), Propellant(5.013, 15.0, zero))
    trace, _ = flown(drawn._replace(plant=drawn.plant._replace(centre=zero)))
    dry, empty_s = DRY + FULL - 5.013, 5.013 * 15.0 * G0 / 40.0
    extra = STEP_S * np.ceil(empty_s / STEP_S) - empty_s
    assert 0.2 < extra / STEP_S < 0.9
    expected = 15.0 * G0 * np.log((DRY + FULL) / dry) + 40.0 / dry * extra
    assert trace["nu_x_m_s"].iloc[-1] == pytest.approx(expected, abs=4e-6)


THRUSTERS = SHIPPED / "thrusters.yaml"
HELD = (
    "horizon={duration_s: 20, step_s: 0.05, control_period_s: 0.05}",
    "capture={window_s: 5}",
    "controller={use: pd-plus}",
    "faults=[{use: effectiveness, onset_s: 0, remaining: {uniform: [0.5, 1]}}]",
)


def campaign(path: Path, propellant: str, *overrides: str) -> tuple[pd.DataFrame, dict[str, float], Drawn]:
    """(trace with every step, metrics, numbers) of the second sample of a campaign."""
    problem = load(path, [*HELD, f"pursuer.propellant={propellant}", *overrides])
    _, drawn = Draws.of(problem, np.arange(4))
    flyer = Flyer.of(problem)
    assert not flyer.engine.fixed_lanes
    found = flyer.fly(drawn, problem.spec.horizon.steps, 1, trace=[1])
    (trace,), _ = trace_tables(found.steps, problem.loop.controller.signals, False, means=found.means)
    return trace, {name: float(x[1]) for name, x in found.values.items()}, flights.lane(drawn, 1)


@pytest.mark.parametrize("allocation", ["bounded-least-squares", "pseudo-inverse"])
def test_what_is_burnt_is_what_the_thrusters_gave(allocation: str) -> None:
    """m₀ − m(T) = Σ h Σ f/(I_sp g₀), with a command that is held for a step and thrusters that open by less than they are told.
    Kills: thrusts before the faults, the total force in the place of the thrusts, opposing thrusters that cancel."""
    propellant = "{mass_kg: 3, specific_impulse_s: {uniform: [180, 240]}, tank_m: [0, 0.1, 0]}"
    trace, values, drawn = campaign(THRUSTERS, propellant, f"actuators.allocation={allocation}")
    thrusts = trace[[f"thrust_t{i + 1}_N" for i in range(24)]].to_numpy()
    assert isinstance(drawn.propellant, Propellant)
    burnt = 0.05 * thrusts[:-1].sum() / (float(drawn.propellant.specific_impulse) * G0)
    assert trace["mass_kg"].iloc[0] == drawn.plant.mass
    assert trace["mass_kg"].iloc[0] - trace["mass_kg"].iloc[-1] == pytest.approx(burnt, rel=1e-9)
    assert values["propellant_used_kg"] == pytest.approx(burnt, rel=1e-9)
    t = trace["t_s"].to_numpy()
    assert values["thrust_impulse_Ns"] == pytest.approx(trapezoid(thrusts.sum(axis=1), t), rel=1e-12)
    assert values["delta_v_m_s"] == pytest.approx(trapezoid(thrusts.sum(axis=1) / trace["mass_kg"], t), rel=1e-12)
    force = np.linalg.norm(columns(trace, "applied_*", ("fx", "fy", "fz")), axis=1)
    assert values["thrust_impulse_Ns"] > 1.2 * trapezoid(force, t), "thrusters push against each other"


def test_what_is_burnt_is_what_the_channels_gave() -> None:
    """The same with six channels, forces and torques of both signs. Kills: torques without their arm, forces with their sign, a
    consumption by the commanded wrench."""
    trace, values, drawn = campaign(CAMPAIGN, "{mass_kg: 3, specific_impulse_s: 210, torque_arm_m: {uniform: [0.4, 0.6]}}")
    assert isinstance(drawn.propellant, Propellant)
    assert not isinstance(drawn.propellant.arm, tuple)
    wrench = np.abs(columns(trace, "applied_*", CHANNELS)[:-1]).sum(axis=0)
    burnt = 0.05 * (wrench[:3].sum() + wrench[3:].sum() / float(drawn.propellant.arm)) / (210.0 * G0)
    assert values["propellant_used_kg"] == pytest.approx(burnt, rel=1e-9)
    assert values["propellant_used_kg"] + values["propellant_left_kg"] == pytest.approx(3.0, rel=1e-12)
    assert (columns(trace, "centre_of_mass_*_m") == 0.0).all()


def test_thrusters_with_an_empty_tank_give_nothing() -> None:
    """Kills: a wrench that goes on without its thrusts, thrusts that go on without their wrench."""
    trace, _, _ = campaign(THRUSTERS, "{mass_kg: 0.005, specific_impulse_s: 210}", "actuators.allocation=pseudo-inverse")
    empty = (trace["propellant_left_kg"] == 0.0).to_numpy()
    thrusts = trace[[f"thrust_t{i + 1}_N" for i in range(24)]].to_numpy()
    assert 0.1 < empty.mean() < 0.99
    assert not thrusts[empty].any()
    assert not columns(trace, "applied_*", CHANNELS)[empty].any()
    assert thrusts[~empty].sum(axis=1).min() > 0.0
    assert columns(trace, "cmd_*", CHANNELS)[empty].any()


def test_all_see_the_plant_of_the_instant() -> None:
    """Disturbances, effects and metrics get the mass and the centre of the instant. Kills: the plant at t = 0 in one of them."""

    def push(t: Any, y: Any, known: Any, plant: Plant, memory: Any, numbers: Numbers) -> Channels:
        return Channels(Vector(plant.mass, 0.0, 0.0), plant.centre)

    def felt(body: Body, x: Any, numbers: Numbers) -> Channels:
        return Channels(Vector(0.0, 0.0, 0.0), Vector(0.0, 0.0, 0.0))

    def told(body: Body, x: Any, numbers: Numbers) -> dict[str, Any]:
        return {"mass": body.mass, "centre": body.centre, "inertia": body.inertia}

    nothing = Numbers({})
    effect = Effect(lambda numbers: (), felt, lambda body, accel, alpha, x, numbers: (), told)
    controller = Controller(start, respond)
    loop = Loop(controller, flights.SATURATIONS["hard-clip"], (), (Disturbance(push),), effects=(effect,))
    zero = np.zeros(6)
    drawn = scene(zero, zero, np.zeros(3), Propellant(FULL, 30.0, Vector(*TANK)))._replace(
        disturbances=(nothing,), effects=(nothing,)
    )
    drawn = jax.tree.map(jnp.asarray, drawn)
    y, held = closed_loop.start(loop, drawn)
    _, step, _ = closed_loop.evaluate(loop, drawn, 0.0, y._replace(consumed=7.0), held, Tick(0, 0.0, STEP_S))
    mass, centre, inertia = body(FULL - 7.0)
    signals = step.effects[0][1]
    for found in (step.plant.mass, step.disturbance.force.x, signals["mass"]):
        assert float(found) == pytest.approx(mass, rel=1e-14)
    for place in (step.plant.centre, step.disturbance.torque, signals["centre"]):
        np.testing.assert_allclose(np.array(place.parts(), float), centre, rtol=1e-11)
    for moments in (step.plant.inertia, signals["inertia"]):
        np.testing.assert_allclose(matrix(moments), inertia, rtol=1e-12)
