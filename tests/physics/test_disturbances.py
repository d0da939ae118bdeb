"""Disturbances against what they are derived from: absolute accelerations in inertial space, potentials, integrals, NumPy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rvjax.components.disturbances import j2_difference
from rvjax.errors import CampaignError
from rvjax.physics.constants import MU_EARTH
from rvjax.physics.state import Motion, State, TargetMotion, Tick
from rvjax.physics.vectors import Vector
from rvjax.simulation.problem import load
from tests import flights
from tests.members import ROWS, array, built, known, scene
from tests.short import CAMPAIGN

Array = NDArray[np.float64]


class Absolute:
    """One sample in the inertial frame: what a disturbance knows nothing of. turn: of T in it."""

    def __init__(self, lane: int, turn: Rotation | None = None, target: tuple[Array, Array] | None = None) -> None:
        motion, self.target, self.plant = flights.lane(scene(), lane)
        self.motion: Motion = motion
        self.turn = turn or Rotation.random(rng=lane)
        if target is not None:
            r, v = (self.turn.inv().apply(x) for x in target)
            self.target = TargetMotion(Vector(*r), Vector(*v), self.target.w)
        self.attitude = self.turn * Rotation.from_mrp(array(motion.sigma))
        w, port = array(self.target.w), array(self.plant.port)
        self.r_t, self.v_t = (self.turn.apply(array(x)) for x in (self.target.r, self.target.v))
        self.r_p = self.r_t + self.turn.apply(port) + self.attitude.apply(array(motion.rho))
        self.v_p = self.v_t + self.turn.apply(np.cross(w, port)) + self.attitude.apply(array(motion.nu))

    def force(self, difference: Array) -> Array:
        """m R(a_p − a_t), in P."""
        return float(self.plant.mass) * self.attitude.inv().apply(difference)


@pytest.mark.parametrize("lane", range(flights.LANES))
def test_drag_is_that_of_two_bodies_in_inertial_space(lane: int) -> None:
    """m (a_p − a_t) from both absolute velocities; no torque.

    Kills: R for Rᵀ, a forgotten ω_t×δ or ν, the pursuer's coefficient for both, the target's drag with the wrong sign.
    """
    scene_of = Absolute(lane)
    functions, numbers = built(
        "disturbances", "differential-drag", 1, density_kg_m3=3e-12, pursuer_m2_kg=0.03, target_m2_kg=0.004
    )
    state, geometry = known(scene_of.motion, scene_of.target, scene_of.plant)
    found = functions.push(0.0, state, geometry, scene_of.plant, (), flights.lane(numbers, 0))

    def drag(v: Array, ballistic: float) -> Array:
        return -0.5 * 3e-12 * ballistic * np.linalg.norm(v) * v

    expected = scene_of.force(drag(scene_of.v_p, 0.03) - drag(scene_of.v_t, 0.004))
    np.testing.assert_allclose(array(found.force), expected, rtol=1e-12, atol=1e-18)
    assert not array(found.torque).any()
    same = built("disturbances", "differential-drag", 1, density_kg_m3=3e-12, pursuer_m2_kg=0.01, target_m2_kg=0.01)[1]
    found = functions.push(0.0, state, geometry, scene_of.plant, (), flights.lane(same, 0))
    expected = scene_of.force(drag(scene_of.v_p, 0.01) - drag(scene_of.v_t, 0.01))
    np.testing.assert_allclose(array(found.force), expected, rtol=0.0, atol=1e-6 * np.linalg.norm(expected))


def exact_pull(r: list[Any]) -> list[Any]:
    """Minus the gradient of J2's potential μJ₂R²/|r|³ (3z²/|r|² − 1)/2, differentiated numerically with 60 digits; pole: z."""

    def potential(*x: Any) -> Any:
        r2 = sum(a * a for a in x)
        return (
            MU_EARTH * j2_difference.J2 * j2_difference.EARTH_RADIUS_M**2 * (3 * x[2] ** 2 / r2 - 1) / (2 * r2 ** mpmath.mpf(1.5))
        )

    return [-mpmath.diff(potential, tuple(r), tuple(int(i == j) for j in range(3)), h=mpmath.mpf(10) ** -15) for i in range(3)]


def exact_difference(r: Array, delta: Array) -> Array:
    """Of the pulls at r + Δ and r."""
    with mpmath.workdps(60):
        near = [mpmath.mpf(float(x)) for x in r]
        far = [a + mpmath.mpf(float(x)) for a, x in zip(near, delta, strict=True)]
        return np.array([float(p - q) for p, q in zip(exact_pull(far), exact_pull(near), strict=True)])


@pytest.mark.parametrize("distance", [1e-3, 1.0, 30.0, 5e3])
@pytest.mark.parametrize(("kind", "allowed"), [(np.float64, 2e-14), (np.float32, 1e-5)])
def test_the_difference_of_j2_has_every_digit(distance: float, kind: type[np.floating[Any]], allowed: float) -> None:
    """Against the difference of two gradients with 60 digits, relative.

    Kills: any term of the difference, a cancellation (two pulls leave ten digits at 10 m in float64, one in float32), an overflow
    of |r|⁷ in float32.
    """
    generator = np.random.default_rng(3)
    for _ in range(5):
        r = generator.normal(size=3)
        r = (r * 6.9e6 / np.linalg.norm(r)).astype(kind)
        delta = (distance * generator.normal(size=3)).astype(kind)
        vectors = [Vector(*map(jnp.asarray, x)) for x in (r, delta, np.array([0, 0, 1], kind))]
        found = array(j2_difference.difference(*vectors))
        exact = exact_difference(r, delta)
        assert found.dtype == kind
        assert np.linalg.norm(found - exact) <= allowed * np.linalg.norm(exact)


INCLINATION, NODE, ARGUMENT, ECCENTRICITY, AXIS_M = 1.1, 0.7, 2.3, 0.1, 7.5e6


def orbit(anomaly: float) -> tuple[Array, Array, float]:
    """r, v in the inertial frame whose pole is the Earth's, and the argument of latitude, at a true anomaly."""
    plane = Rotation.from_euler("ZXZ", [NODE, INCLINATION, ARGUMENT])
    parameter = AXIS_M * (1.0 - ECCENTRICITY**2)
    out = np.array([np.cos(anomaly), np.sin(anomaly), 0.0])
    r = parameter / (1.0 + ECCENTRICITY * np.cos(anomaly)) * out
    v = np.sqrt(MU_EARTH / parameter) * np.array([-np.sin(anomaly), ECCENTRICITY + np.cos(anomaly), 0.0])
    return plane.apply(r), plane.apply(v), ARGUMENT + anomaly


def anomaly_at(t: float) -> float:
    """True anomaly [rad] at a time [s] after the perigee, by Kepler's equation."""
    mean = np.sqrt(MU_EARTH / AXIS_M**3) * t
    eccentric = mean
    for _ in range(50):
        eccentric -= (eccentric - ECCENTRICITY * np.sin(eccentric) - mean) / (1.0 - ECCENTRICITY * np.cos(eccentric))
    return 2.0 * np.arctan(np.sqrt((1 + ECCENTRICITY) / (1 - ECCENTRICITY)) * np.tan(0.5 * eccentric))


@pytest.mark.parametrize("lane", range(flights.LANES))
@pytest.mark.parametrize("anomaly", [0.0, 2.5])
def test_j2_is_that_of_two_bodies_in_inertial_space(lane: int, anomaly: float) -> None:
    """m (a_p − a_t) from both absolute positions on an inclined ellipse, whatever the target's attitude; no torque.

    Kills: sin u for cos u in the pole, r̂×ĥ for ĥ×r̂, the pole in T for P, a forgotten port, the force on the target.
    """
    r, v, latitude = orbit(anomaly)
    one = Absolute(lane, target=(r, v))
    given = {"inclination_deg": np.degrees(INCLINATION), "latitude_deg": np.degrees(latitude)}
    functions, numbers = built("disturbances", "j2-difference", 1, **given)
    numbers = flights.lane(numbers, 0)
    state, geometry = known(one.motion, one.target, one.plant)
    memory = functions.keep(Tick(0, 0.0, 0.05), state, functions.start(numbers), numbers)
    found = functions.push(0.0, state, geometry, one.plant, memory, numbers)
    expected = one.force(exact_difference(one.r_t, one.r_p - one.r_t))
    np.testing.assert_allclose(array(found.force), expected, rtol=0.0, atol=1e-8 * np.linalg.norm(expected))
    assert not array(found.torque).any()


def test_the_argument_of_latitude_follows_the_orbit() -> None:
    """600 s along an ellipse, from step to step and within one, against Kepler's equation, to five times what is said.

    Kills: a rate that is not renewed, a missing second derivative, its sign, u that starts over at each step.
    """
    h, steps, first = 1.0, 600, 900.0
    times = first + h * np.arange(steps + 1)
    rows = np.array([np.concatenate(orbit(anomaly_at(t))[:2]) for t in times])
    turn = Rotation.from_rotvec(np.outer(times, [0.004, -0.006, 0.003])).inv()
    r, v = turn.apply(rows[:, :3]), turn.apply(rows[:, 3:])
    functions, numbers = built(
        "disturbances", "j2-difference", 1, inclination_deg=50, latitude_deg=np.degrees(ARGUMENT + anomaly_at(first))
    )
    numbers = flights.lane(numbers, 0)
    motion = scene()[0]

    def step(memory: Any, row: Any) -> tuple[Any, Any]:
        k, position, velocity = row
        state = State(motion, TargetMotion(Vector(*position), Vector(*velocity), motion.omega), ())
        memory = functions.keep(Tick(k, k * h, h), state, memory, numbers)
        return memory, jnp.stack([j2_difference.latitude(k * h + part * h, memory) for part in (0.0, 0.5)])

    _, found = jax.jit(lambda: jax.lax.scan(step, functions.start(numbers), (jnp.arange(steps + 1), r, v)))()
    expected = np.array([[ARGUMENT + anomaly_at(t + part * h) for part in (0.0, 0.5)] for t in times])
    allowed = 5.0 * ECCENTRICITY * (MU_EARTH / AXIS_M**3) ** 1.5 * h * h * steps * h / 3.0
    assert 1e-10 < np.abs(found - expected).max() <= allowed


def pulses(times: Array, **said: Any) -> Array:
    """(times, 6) of one sample."""
    functions, numbers = built("disturbances", "plume-pulse", 1, force_N=[0.4, -0.2, 0.1], torque_Nm=[0, 0.03, 0], **said)
    return array(functions.push(jnp.asarray(times), None, None, None, (), flights.lane(numbers, 0)))


HEIGHT = np.array([0.4, -0.2, 0.1, 0.0, 0.03, 0.0])


def test_a_pulse_has_its_impulse_its_height_and_its_times() -> None:
    """∫d dt = a w (f, τ) a pulse, whatever the edge; all of it on the plateau, half in the middle of an edge, nothing outside.

    Kills: an edge that adds to the width, a fall that is not mirrored, a phase from t = 0, pulses before the first, one period
    too many, a strength on the force alone.
    """
    times = np.linspace(0.0, 20.0, 200_001)
    for edge in (0.05, 0.4, 2.0):
        found = pulses(times, strength=1.5, first_s=5.0, width_s=0.7, edge_s=edge, period_s=4.0)
        np.testing.assert_allclose(np.trapezoid(found, times, axis=0), 4 * 0.7 * 1.5 * HEIGHT, rtol=1e-8)
        assert not found[(times < 5.0) | ((times > 5.7 + edge) & (times < 9.0))].any()
    at = np.array([2.9, 3.1, 3.2, 3.5, 3.8, 3.9, 4.2, 9.1, 9.5])
    found = pulses(at, first_s=3.0, width_s=0.7, edge_s=0.2, period_s=6.0)
    np.testing.assert_allclose(
        found / HEIGHT.max(), np.outer([0, 0.5, 1, 1, 0.5, 0, 0, 0.5, 1], HEIGHT / HEIGHT.max()), atol=1e-12
    )
    once = pulses(times, first_s=3.0, width_s=0.7, edge_s=0.2)
    np.testing.assert_allclose(np.trapezoid(once, times, axis=0), 0.7 * HEIGHT, rtol=1e-8)


def impulse_error(edge: float, h: float) -> float:
    """Of pulses that begin and end anywhere in a step: the most that RK4's quadrature, Simpson's rule, is wrong by, in h f."""
    times = np.arange(0.0, 4.0 + 0.25 * h, 0.5 * h)
    errors: list[float] = []
    for first in 1.0 + h * np.linspace(0.0, 1.0, 21):
        for width in 0.7 + h * np.linspace(0.0, 1.0, 21):
            d = pulses(times, first_s=first, width_s=width, edge_s=edge)[:, 0]
            errors.append(h / 6.0 * (d[:-2:2] + 4.0 * d[1:-1:2] + d[2::2]).sum() - width * 0.4)
    return float(np.abs(errors).max() / (h * 0.4))


def test_what_rk4_makes_of_an_edge() -> None:
    """The impulse of a pulse with an edge of five steps is right to 2e-4 of a step and of order four, with a rectangular edge
    wrong by up to two thirds of a step. Kills: an edge with a kink, a claim that is not so."""
    resolved, finer = impulse_error(0.25, 0.05), impulse_error(0.25, 0.025)
    assert resolved <= 2e-4
    assert resolved * 0.05 / (finer * 0.025) >= 12.0
    assert 0.6 <= impulse_error(1e-9, 0.05) <= 2.0 / 3.0 + 1e-9


@pytest.mark.parametrize("h", [0.05, 0.8])
def test_a_table_is_interpolated(h: float) -> None:
    """a · np.interp(t − t₀) where a step begins, a straight line within one; also with rows closer than a step, before the first
    and behind the last.

    Kills: the row before, t + t₀, a slope of the wrong row, a scale on the force alone.
    """
    samples, steps = 5, int(6.0 / h)
    functions, numbers = built(
        "disturbances", "table", samples, rows=ROWS, scale={"uniform": [0.5, 1.5]}, shift_s={"uniform": [-0.7, 0.7]}
    )

    def one(own: Any) -> Any:
        def step(memory: Any, k: Any) -> tuple[Any, Any]:
            memory = functions.keep(Tick(k, k * h, h), None, memory, own)
            return memory, [functions.push((k + part) * h, None, None, None, memory, own).parts() for part in (0.0, 0.5)]

        return jax.lax.scan(step, functions.start(own), jnp.arange(steps))[1]

    begun, middle = (np.stack(parts, axis=-1) for parts in jax.jit(jax.vmap(one))(numbers))
    table, times = np.array(ROWS), h * np.arange(steps + 1)
    for sample in range(samples):
        at = times - np.asarray(numbers.shift_s)[sample]
        columns = [np.interp(at, table[:, 0], table[:, 1 + i]) for i in range(6)]
        expected = np.asarray(numbers.scale)[sample] * np.stack(columns, axis=-1)
        np.testing.assert_allclose(begun[sample], expected[:-1], atol=1e-13)
        np.testing.assert_allclose(middle[sample], 0.5 * (expected[:-1] + expected[1:]), atol=1e-13)


def test_a_long_table_is_looked_up_in_every_row() -> None:
    """2,000 rows, two samples each. Kills: an off-by-one of the search at either end."""
    rows = [[float(t), float(np.sin(t)), 0, 0, 0, 0, 0] for t in np.cumsum(np.random.default_rng(1).uniform(0.1, 2.0, 2000))]
    functions, numbers = built("disturbances", "table", 4000, rows=rows, shift_s={"uniform": [-2100, 10]})
    found = jax.jit(jax.vmap(functions.start))(numbers).last.force.x
    table = np.array(rows)
    np.testing.assert_allclose(found, np.interp(-np.asarray(numbers.shift_s), table[:, 0], table[:, 1]), atol=1e-12)


def test_a_table_comes_from_a_file_as_well(tmp_path: Path) -> None:
    """The same table, columns in any order, those that are not there 0; a table that falls back in time, both ways at once and
    neither are refused. Kills: columns by place for columns by name."""
    (tmp_path / "push.csv").write_text("tz_Nm,t_s,fy_N\n0.1,0,1\n0.2,2,-1\n0,5,0\n")
    (tmp_path / "back.csv").write_text("t_s,fx_N\n0,1\n0,2\n")
    text = CAMPAIGN.read_text().partition("disturbances:")[0] + "controller: {use: pd-plus}\n"

    def table(said: str) -> Array:
        (tmp_path / "campaign.yaml").write_text(text + f"disturbances: [{{use: table, {said}}}]\n")
        (start,) = (one.start for one in load(tmp_path / "campaign.yaml").loop.disturbances)
        return start.args[0]

    rows = "[[0, 0, 1, 0, 0, 0, 0.1], [2, 0, -1, 0, 0, 0, 0.2], [5, 0, 0, 0, 0, 0, 0]]"
    np.testing.assert_array_equal(table("csv: push.csv"), table(f"rows: {rows}"))
    for said, words in (
        ("csv: back.csv", "back.csv line 3 has the time 0 s"),
        (f"csv: push.csv, rows: {rows}", "both"),
        ("scale: 2", "neither"),
    ):
        with pytest.raises(CampaignError, match=words):
            table(said)
