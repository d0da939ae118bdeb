"""Effects against oracles that share no code with them: two masses on a spring, a pendulum in the inertial frame by
constraints."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rvjax.components.effects import flexible_appendage, slosh_pendulum
from rvjax.components.registry import component
from rvjax.errors import CampaignError
from rvjax.execution.replay import replay
from rvjax.execution.run import run
from rvjax.physics.dynamics import Relative
from rvjax.physics.state import Numbers, Plant
from rvjax.physics.vectors import Channels, Rotation, Symmetric, Vector, inverse
from rvjax.simulation import rk4
from rvjax.simulation.effects_sum import acceleration, effects_sum
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN, SHORT

Array = np.ndarray[Any, Any]
MASS = 90.0
INERTIA = np.array([[20.0, 1.0, -0.5], [1.0, 24.0, 0.7], [-0.5, 0.7, 17.0]])
FORCE, TORQUE, RATE = np.array([2.0, -1.0, 0.5]), np.array([0.3, 0.2, -0.4]), np.array([0.05, -0.1, 0.2])


def plant() -> Plant:
    """The body without what moves in it."""
    j = Symmetric(*[float(INERTIA[i]) for i in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))])
    zero = Vector(0.0, 0.0, 0.0)
    wrench = Channels(zero, zero)
    return Plant(MASS, j, inverse(j), wrench, wrench, j, inverse(j), zero, zero)


def flown(names: list[str], numbers: list[Numbers], rate: Array, duration: float, step: float) -> tuple[Array, list[Any]]:
    """(Ω, states of the effects) after a flight of the body under the constant wrench, by the package's equations."""
    effects = [component("effects", name).build(None) for name in names]
    body, zero = plant(), Vector(0.0, 0.0, 0.0)
    wrench = Channels(Vector(*FORCE), Vector(*TORQUE))

    def slope(t: Any, y: Any) -> Any:
        omega, states = y
        known = Relative(Rotation(zero, zero, zero), omega, zero, zero, zero)
        total, rates, _ = effects_sum(effects, numbers, states, t, known, body, wrench)
        return acceleration(known, body, total)[1], rates

    y = (Vector(*rate), tuple(effect.start(given) for effect, given in zip(effects, numbers, strict=True)))
    y = jax.tree.map(jnp.asarray, y)

    @jax.jit
    def whole(y: Any) -> Any:
        return jax.lax.fori_loop(
            0, round(duration / step), lambda k, y: rk4.step(slope, k * step, y, step, slope(k * step, y)), y
        )

    omega, states = whole(y)
    return np.array(omega.parts()), list(states)


def test_a_mass_on_a_spring_is_two_masses(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the centre of mass, without damping: y = −(f/m)(1 − cos ω't)/ω'², ω'² = ω²(1 + m_a/m). Kills: a reaction that is
    missing or has the other sign, the total mass in the place of the body's."""
    monkeypatch.setitem(globals(), "TORQUE", np.zeros(3))
    frequency, modal = np.array([2.0, 3.0, 1.0]), 10.0
    numbers = Numbers({
        "modal_mass_kg": modal, "frequency_rad_s": Vector(*frequency), "damping": 0.0, "place_m": Vector(0.0, 0.0, 0.0)
    })  # fmt: skip
    _, (mode,) = flown(["flexible-appendage"], [numbers], np.zeros(3), 5.0, 0.005)
    together = frequency * np.sqrt(1.0 + modal / MASS)
    expected = -FORCE / MASS * (1.0 - np.cos(together * 5.0)) / together**2
    np.testing.assert_allclose(np.array(mode.displacement.parts()), expected, atol=1e-9)


def test_damping_is_that_of_the_held_body() -> None:
    """A very heavy body that turns slowly holds the appendage: y decays as e^{−ζωt}. Kills: a factor 2 in the damping."""
    numbers = Numbers(
        {"modal_mass_kg": 1.0, "frequency_rad_s": Vector(2.0, 2.0, 2.0), "damping": 0.1, "place_m": Vector(0.0, 0.0, 0.0)}
    )
    effect = component("effects", "flexible-appendage").build(None)
    still = Vector(0.0, 0.0, 0.0)
    body = effect_body(np.zeros(3))
    y = flexible_appendage.Mode(Vector(1.0, 0.0, 0.0), still)

    def slope(t: Any, x: Any) -> Any:
        return effect.rate(body, still, still, x, numbers)

    start = jax.tree.map(jnp.asarray, y)
    y = jax.jit(lambda y: jax.lax.fori_loop(0, 2000, lambda k, y: rk4.step(slope, k * 0.005, y, 0.005, slope(0.0, y)), y))(start)
    damped = 2.0 * np.sqrt(1.0 - 0.01)
    expected = np.exp(-0.2 * 10.0) * (np.cos(damped * 10.0) + 0.1 / np.sqrt(0.99) * np.sin(damped * 10.0))
    np.testing.assert_allclose(float(y.displacement.x), expected, atol=1e-8)


def effect_body(rate: Array) -> Any:
    """The body without acceleration."""
    from rvjax.components.effects.interface import Body

    zero, p = Vector(0.0, 0.0, 0.0), plant()
    return Body(0.0, Vector(*rate), p.mass, p.inertia, p.inertia_inverse, zero, zero, zero)


SLOSH, LENGTH, PIVOT, DAMPING = 8.0, 0.4, np.array([0.1, -0.2, 0.05]), 1.5
DOWN = np.array([-0.8, 0.5, 0.33])
ROD = DOWN * LENGTH / np.linalg.norm(DOWN)


def by_constraints(duration: float) -> tuple[Array, Array, Array]:
    """(Ω in the body, direction of the rod in the body, total momentum) of body and bob in the inertial frame: Newton and Euler
    with the tension as an unknown, and the length of the rod differentiated twice."""
    e = DOWN / np.linalg.norm(DOWN)

    def cross(a: Array) -> Array:
        return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])

    def slope(t: float, y: Array) -> Array:
        turn, v, w, place, speed = y[3:12].reshape(3, 3), y[12:15], y[15:18], y[18:21], y[21:24]
        spin = turn @ w
        inertia = turn @ INERTIA @ turn.T
        arm = turn @ PIVOT
        rod = place - (y[:3] + arm)
        direction = rod / np.linalg.norm(rod)
        q = place - y[:3]
        relative = speed - (v + np.cross(spin, q))
        drag = DAMPING * relative  # on the body, at the bob
        # unknowns: acceleration of the body (3), its angular acceleration (3), of the bob (3), the tension
        a, b = np.zeros((10, 10)), np.zeros(10)
        a[0:3, 0:3], a[0:3, 9], b[0:3] = MASS * np.eye(3), -direction, turn @ FORCE + drag
        a[3:6, 3:6], a[3:6, 9] = inertia, -np.cross(q, direction)
        b[3:6] = turn @ TORQUE + np.cross(q, drag) - np.cross(spin, inertia @ spin)
        a[6:9, 6:9], a[6:9, 9], b[6:9] = SLOSH * np.eye(3), direction, -drag
        a[9, 6:9], a[9, 0:3], a[9, 3:6] = rod, -rod, rod @ cross(arm)
        pivot_speed = v + np.cross(spin, arm)
        b[9] = rod @ np.cross(spin, np.cross(spin, arm)) - (speed - pivot_speed) @ (speed - pivot_speed)
        solved = np.linalg.solve(a, b)
        return np.concatenate([v, (cross(spin) @ turn).ravel(), solved[:3], turn.T @ (solved[3:6]), speed, solved[6:9]])

    place = PIVOT + LENGTH * e
    begin = np.concatenate([np.zeros(3), np.eye(3).ravel(), np.zeros(3), RATE, place, np.cross(RATE, place)])
    end = solve_ivp(slope, (0.0, duration), begin, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    turn = end[3:12].reshape(3, 3)
    rod = turn.T @ (end[18:21] - end[:3]) - PIVOT
    return end[15:18], rod / np.linalg.norm(rod), MASS * end[12:15] + SLOSH * end[21:24]


def test_the_pendulum_moves_as_in_the_inertial_frame() -> None:
    """Rate of the body and direction of the rod after 6 s, with damping, off the centre of mass. Kills: a missing Coriolis,
    centrifugal or Euler term, a tension without the body's reaction, damping without its torque."""
    numbers = Numbers({
        "slosh_mass_kg": SLOSH, "pivot_m": Vector(*PIVOT), "rod_m": Vector(*ROD), "damping": DAMPING
    })  # fmt: skip
    omega, (pendulum,) = flown(["slosh-pendulum"], [numbers], RATE, 6.0, 0.002)
    expected, direction, _ = by_constraints(6.0)
    np.testing.assert_allclose(omega, expected, atol=2e-8)
    np.testing.assert_allclose(np.array(slosh_pendulum.unit(pendulum).direction.parts()), direction, atol=2e-7)
    assert abs(direction @ DOWN / np.linalg.norm(DOWN)) < 0.95, "it has swung"


EFFECTS = (
    "effects=[{use: slosh-pendulum, slosh_mass_kg: {uniform: [5, 10]}, rod_m: [-0.4, 0, 0.1]}, "
    "{use: flexible-appendage, modal_mass_kg: 4, frequency_Hz: {uniform: [0.2, 0.5]}, place_m: [0, 1, 0]}]"
)


@pytest.mark.usefixtures("bare")
def test_a_campaign_flies_them(tmp_path: Path) -> None:
    """Draws act, states and signals are in the trace with their units, and temporal margins see them. Kills: a state that is
    not integrated, an effect whose wrench does not reach the body, a margin over the signal of another effect."""
    rod = "rod: {always: {signal: effects.slosh-pendulum.tension, below: 9}}"
    tip = "tip: {always: {signal: effects.flexible-appendage.displacement_y, above: -1}}"
    overrides = [*SHORT, "controller={use: pd-plus}", EFFECTS, f"margins={{{rod}, {tip}}}", "samples=8"]
    folder = run(CAMPAIGN, tmp_path / "run", overrides, progress=False)
    trace, columns, row = replay(folder, 1)
    assert row["metric.margin.rod"] == pytest.approx(np.min(9.0 - trace["effects.slosh-pendulum.tension"]), rel=1e-12)
    assert row["metric.margin.tip"] == pytest.approx(np.min(1.0 + trace["effects.flexible-appendage.displacement_y"]), rel=1e-12)
    assert columns["effects.slosh-pendulum.tension"].unit == "N"
    assert columns["effects.flexible-appendage.displacement_y"].unit == "m"
    names = [name for name in trace.columns if name.startswith("effects.")]
    assert all(np.ptp(trace[name]) > 0.0 for name in names if "_rate_" not in name), names
    direction = trace[[f"effects.slosh-pendulum.direction_{axis}" for axis in "xyz"]].to_numpy()
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, rtol=1e-12)
    assert row["draw.effects.slosh-pendulum.slosh_mass_kg"] > 5.0


def test_two_effects_that_need_the_acceleration_are_refused() -> None:
    """Kills: two pendulums, each of which ignores the other."""
    one, other = (f"{{use: slosh-pendulum, name: {name}, slosh_mass_kg: 1, rod_m: [0, 1, 0]}}" for name in "ab")
    two = f"effects=[{one}, {other}]"
    with pytest.raises(CampaignError, match="each need the acceleration that the other changes"):
        load(CAMPAIGN, [two])


@pytest.mark.parametrize(
    ("effects", "signal", "words"),
    [
        (EFFECTS, "effects.slosh-pendulum.tensoin", "of the effect slosh-pendulum; did you mean effects.slosh-pendulum.tension"),
        (EFFECTS, "effects.slosh.tension", "no signal of an effect; did you mean effects.slosh-pendulum.tension"),
        ("effects=[]", "effects.slosh-pendulum.tension", "is not recorded: there are no effects"),
    ],
)
def test_a_wrong_name_in_a_margin_is_named(effects: str, signal: str, words: str) -> None:
    """Kills: a traceback, a message without the nearest name."""
    with pytest.raises(CampaignError, match=words):
        load(CAMPAIGN, [effects, f"margins={{m: {{always: {{signal: {signal}, below: 9}}}}}}"])


def test_a_wrong_effect_gives_no_second_finding_about_its_signals() -> None:
    """Kills: a margin that is blamed for a mistake in the effect."""
    wrong = EFFECTS.replace("modal_mass_kg: 4", "modal_mass_kg: -4")
    with pytest.raises(CampaignError) as caught:
        load(CAMPAIGN, [wrong, "margins={m: {always: {signal: effects.flexible-appendage.displacement_y, below: 9}}}"])
    assert len(caught.value.findings) == 1


def test_without_effects_nothing_is_compiled_for_them() -> None:
    """Kills: states and numbers in a flight without effects."""
    problem = load(CAMPAIGN)
    assert problem.loop.effects == problem.loop.actuation == ()
