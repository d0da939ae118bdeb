"""A start in a frame: the absolute state of each draw is that of the oracle, and what is at rest flies as it must."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import jax
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rvjax.physics.state import Motion, TargetMotion
from rvjax.physics.vectors import Vector
from rvjax.simulation import start_frames
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from tests import flights
from tests.flights import Recorder
from tests.oracles import start_frames as oracle
from tests.short import CAMPAIGN

Array = NDArray[np.float64]

FRAMES = ("port", "lvlh", "pursuer")
RESTS = ("port", "lvlh", "inertial")
SAMPLES = 48
ORBITS = {"circular": "0", "eccentric": "{uniform: [0.05, 0.4]}"}
TARGET = (
    "target={orbit: {semi_major_axis_km: {uniform: [12000, 16000]}, eccentricity: %s, true_anomaly_deg: {uniform: [0, 360]}}, "
    "attitude_mrp: {rotation: uniform}, rate_deg_s: {box: 2}, port_m: {box: 6}%s}"
)
START = (
    "start={frame: %s, relative_to: %s, position_m: {box: 150}, velocity_m_s: {box: 0.5}, attitude_mrp: {rotation: uniform}, "
    "rate_deg_s: {box: 1}}"
)
AXES = (
    [1, 0, 0],
    [-3, 0, 0],
    [-1, 1e-9, 0],
    [-1, 0, -1e-200],
    [-1, 1e-4, -2e-4],
    [0, 0.2, 0],
    [0, 0, -1],
    [-2, 1, -3],
    [2, 5, 1],
)


def drawn(*overrides: str, samples: int = SAMPLES) -> tuple[Mapping[str, Array], Drawn]:
    draws, numbers = Draws.of(load(CAMPAIGN, overrides), np.arange(samples, dtype=np.int64))
    return draws.values, numbers


def vector(values: Mapping[str, Array], name: str, sample: int) -> Array:
    return np.array([values[f"{name}.{axis}"][sample] for axis in "xyz"])


def assert_absolute(frame: str, relative_to: str, values: Mapping[str, Array], numbers: Drawn, axis: Any = None) -> None:
    """Every sample: distances below 1e-12 of the largest of their terms."""
    for sample in range(SAMPLES):
        target = oracle.Target(
            values["target.orbit.semi_major_axis_m"][sample],
            values.get("target.orbit.eccentricity", np.zeros(SAMPLES))[sample],
            values["target.orbit.true_anomaly_rad"][sample],
            Rotation.from_mrp(vector(values, "target.attitude_mrp", sample)),
            vector(values, "target.rate_rad_s", sample),
            port := vector(values, "target.port_m", sample),
            port if axis is None else np.array(axis),
        )
        position, velocity, attitude, rate = (
            vector(values, f"start.{name}", sample) for name in ("position_m", "velocity_m_s", "attitude_mrp", "rate_rad_s")
        )
        start = oracle.Start(position, velocity, Rotation.from_mrp(attitude), rate)
        expected = oracle.pursuer(frame, relative_to, start, target)
        lane = flights.lane(numbers.motion, sample)
        rho, nu, sigma, omega = (np.array(part.parts()) for part in lane)
        found = oracle.flown(rho, nu, sigma, omega, target)
        longest = np.linalg.norm(position) + np.linalg.norm(port)
        fastest = np.linalg.norm(velocity) + longest * (np.linalg.norm(target.rate) + 1e-3)
        assert np.linalg.norm(found.position - expected.position) < 1e-12 * longest
        assert np.linalg.norm(found.velocity - expected.velocity) < 1e-12 * fastest
        assert (found.attitude.inv() * expected.attitude).magnitude() < 1e-12
        assert np.linalg.norm(found.rate - expected.rate) < 1e-12 * (np.linalg.norm(rate) + np.linalg.norm(target.rate))
        assert np.linalg.norm(lane.sigma.parts()) < 1.0 + 1e-14


@pytest.mark.parametrize("orbit", ORBITS)
@pytest.mark.parametrize("relative_to", RESTS)
@pytest.mark.parametrize("frame", FRAMES)
def test_the_absolute_state_is_that_of_the_oracle(frame: str, relative_to: str, orbit: str) -> None:
    """Any attitude, a tumbling target, any place on the orbit. Kills: signs of the axes, transposed attitudes, a missing ω×d or
    ω×δ, the mean motion for the rate of LVLH, a rate in the axes of the frame."""
    values, numbers = drawn(TARGET % (ORBITS[orbit], ""), START % (frame, relative_to))
    assert_absolute(frame, relative_to, values, numbers)


@pytest.mark.parametrize("axis", AXES, ids=str)
def test_the_port_axis_turns_the_frame_of_the_port(axis: list[float]) -> None:
    """It goes before the direction of port_m, also near −x, where the shortest turn has no axis. Kills: 1/(1 + n_x) with no digit
    left, a longer turn, a direction that is not made a unit vector, a turn about another axis."""
    values, numbers = drawn(TARGET % (ORBITS["eccentric"], f", port_axis: {axis}"), START % ("port", "port"))
    assert_absolute("port", "port", values, numbers, axis)
    inside = np.array(numbers.context.axis.parts())
    np.testing.assert_allclose(inside, np.outer(np.array(axis) / np.linalg.norm(axis), np.ones(SAMPLES)), rtol=0, atol=1e-15)
    assert np.all(numbers.context.cone > 0.98)


def test_without_a_port_axis_the_approach_cone_is_about_the_port() -> None:
    """Kills: a given axis that is not used, a cone without an axis."""
    values, numbers = drawn(TARGET % ("0", ""))
    port = np.array([values[f"target.port_m.{axis}"] for axis in "xyz"])
    np.testing.assert_allclose(numbers.context.axis.parts(), port / np.linalg.norm(port, axis=0), rtol=0, atol=1e-15)
    _, bare = drawn("target={}")
    _, given = drawn("target={port_axis: [0, 0, 2]}")
    assert np.all(bare.context.cone == -2.0)
    assert np.all(given.context.cone > 0.98)


def test_hold_points_are_where_their_names_say() -> None:
    """Behind on V-bar, below on R-bar, to the right of the velocity on H-bar, as seen head up. Kills: the sign of an axis in both
    the code and the oracle."""
    for place, along in (([-100, 0, 0], "behind"), ([0, 0, 30], "below"), ([0, 20, 0], "right")):
        _, numbers = drawn(
            "target={orbit: {eccentricity: 0}, rate_deg_s: 1}", f"start={{frame: lvlh, position_m: {place}}}", samples=1
        )
        r, v, rho = (np.array(flights.lane(x, 0).parts()) for x in (numbers.target.r, numbers.target.v, numbers.motion.rho))
        p = Rotation.from_mrp(np.array(flights.lane(numbers.motion.sigma, 0).parts())).apply(rho)
        ways = {"behind": -v, "below": -r, "right": np.cross(v, r)}
        size = np.linalg.norm(place)
        assert p @ ways[along] / np.linalg.norm(ways[along]) == pytest.approx(size, rel=1e-12)


@pytest.mark.parametrize("angle", [0.0, 1e-8, 1.0, np.pi - 1e-8, np.pi])
@pytest.mark.parametrize("about", [[1, 0, 0], [0, -1, 0], [0, 0, 1], [1, 1, 1], [-1, 2, -2], [1, -3, 1]], ids=str)
def test_any_attitude_in_lvlh_becomes_that_of_the_target(about: list[float], angle: float) -> None:
    """Kills: a quaternion from a matrix by the trace alone, which has no digits near half a turn."""
    turn = Rotation.from_rotvec(angle * np.array(about) / np.linalg.norm(about))
    rows = turn.inv().as_matrix()  # T → LVLH: the rows are the axes of LVLH in T
    r, v = -7e6 * rows[2], 7.5e3 * rows[0]
    target = TargetMotion(*(Vector(*x.reshape(3, 1)) for x in (r, v, np.zeros(3))))
    zero = Vector(*np.zeros((3, 1)))
    axis = (zero, np.zeros(1, bool))
    found = start_frames.start_motion("lvlh", "lvlh", start_frames.Given(zero, zero, zero, zero), target, zero, axis)
    sigma = np.array(found.sigma.parts())[:, 0]
    assert (Rotation.from_mrp(sigma).inv() * turn).magnitude() < 4e-15
    assert np.linalg.norm(sigma) < 1.0 + 1e-14


CIRCULAR = "target={orbit: {semi_major_axis_km: 6878, eccentricity: 0}, port_m: [5, 0, 0], rate_deg_s: [0.23, -0.34, 0.17]}"
FREE = {
    "v-bar": "{frame: lvlh, position_m: [-100, 0, 0]}",
    "r-bar": "{frame: lvlh, position_m: [0, 0, 30]}",
    "h-bar": "{frame: lvlh, position_m: [0, 50, 0]}",
    "port": "{frame: port, position_m: [20, 4, -3]}",
}
"""Starts at rest in their frames, one for each lane of a flight."""


@pytest.fixture(scope="module")
def drift(pd_plus: Recorder) -> Mapping[str, Mapping[str, Array]]:
    """Half an orbit without any wrench, in steps of 1 s. t [s]; place in LVLH and in T from the centre of the target [m]."""
    scenes = [drawn(CIRCULAR, f"start={start}", samples=1)[1] for start in FREE.values()]
    joined = jax.tree.map(lambda *x: np.concatenate(x), *((scene.motion, scene.target, scene.plant.port) for scene in scenes))
    motion: Motion
    motion, target, port = joined
    base = flights.silenced(flights.draw(flights.gains("pd-plus"), 3000.0, 1.0, onset_s=0.0))
    record = pd_plus(base._replace(motion=motion, target=target, plant=base.plant._replace(port=port)), 1)
    return {name: places(trace) for name, trace in zip(FREE, record.traces, strict=True)}


def places(trace: Any) -> Mapping[str, Array]:
    r, v, sigma, rho = (
        np.stack([trace[pattern.replace("*", axis)] for axis in "xyz"], axis=-1)
        for pattern in ("target_r_*_m", "target_v_*_m_s", "sigma_*", "rho_*_m")
    )
    p = Rotation.from_mrp(sigma).apply(rho) + np.array([5.0, 0.0, 0.0])
    z, h = -r / np.linalg.norm(r, axis=1)[:, None], np.cross(r, v)
    y = -h / np.linalg.norm(h, axis=1)[:, None]
    in_lvlh = np.stack([np.sum(p * axis, axis=1) for axis in (np.cross(y, z), y, z)], axis=-1)
    return {"t": np.array(trace["t_s"]), "lvlh": in_lvlh, "T": p}


A = 6.878e6
N = np.sqrt(oracle.MU / A**3)


def second_order(excursion: float) -> float:
    """What Hill's equations leave out: (excursion)²/a, times the growth of a few over half an orbit."""
    return 20.0 * excursion**2 / A


def test_at_rest_on_v_bar_nothing_drifts(drift: Mapping[str, Mapping[str, Array]]) -> None:
    """Hill's equations: ẍ = 2nż, z̈ = −2nẋ + 3n²z have every point of V-bar at rest. Kills: velocities that miss ω_o×d, which
    drift by 1 km."""
    away = drift["v-bar"]["lvlh"] - (-100.0, 0.0, 0.0)
    assert np.max(np.abs(away)) < second_order(100.0)


def test_at_rest_on_r_bar_it_drifts_as_clohessy_and_wiltshire_say(drift: Mapping[str, Mapping[str, Array]]) -> None:
    """z = z₀(4 − 3 cos nt), x = 6 z₀(nt − sin nt): ahead, because it is below. Kills: R-bar up, V-bar backward."""
    t, found = drift["r-bar"]["t"], drift["r-bar"]["lvlh"]
    expected = np.stack([180.0 * (N * t - np.sin(N * t)), 0.0 * t, 30.0 * (4.0 - 3.0 * np.cos(N * t))], axis=-1)
    most = float(np.max(np.abs(expected)))
    assert most > 600.0
    assert np.max(np.abs(found - expected)) < second_order(most)


def test_at_rest_on_h_bar_it_swings(drift: Mapping[str, Mapping[str, Array]]) -> None:
    """y = y₀ cos nt. Kills: a turn of LVLH about another axis."""
    t, found = drift["h-bar"]["t"], drift["h-bar"]["lvlh"]
    expected = np.stack([0.0 * t, 50.0 * np.cos(N * t), 0.0 * t], axis=-1)
    assert np.max(np.abs(found - expected)) < second_order(50.0)


def test_at_rest_relative_to_the_port_it_stays_before_the_target(drift: Mapping[str, Mapping[str, Array]]) -> None:
    """ρ in T leaves its place with t²: |ω|²|p| t²/2 and the tide of 3n²|p|, less than 5 cm in 8 s. Kills: velocities that miss
    ω_t×ρ, with which it is 1 m."""
    place = drift["port"]["T"][:9]
    np.testing.assert_allclose(place[0], (25.0, 4.0, -3.0), rtol=1e-13)
    moved = np.linalg.norm(place - place[0], axis=1)
    spin, size = np.radians(np.linalg.norm([0.23, -0.34, 0.17])), np.linalg.norm(place[0])
    assert np.all(moved <= 0.6 * (spin**2 + 3.0 * N**2) * size * np.arange(9.0) ** 2 + 1e-12)
    assert moved[8] > 4e-3
