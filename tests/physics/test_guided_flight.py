"""Flights with guidance: what the controller gets of the reference point, and the reference point against its documentation."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rvjax.components.controllers import pd_plus
from rvjax.components.forms.controller import unlimited
from rvjax.components.forms.measured import Measured
from rvjax.components.guidance import corridor, interface, waypoints
from rvjax.execution.replay import replay
from rvjax.execution.run import run
from rvjax.physics.dynamics import motion_rate, relative, target_alpha, target_rate
from rvjax.physics.state import Measurement, Motion, Numbers, TargetMotion, Tick
from rvjax.physics.state import Path as Reference
from rvjax.physics.vectors import Symmetric, Vector, rotate, rotation
from rvjax.simulation import closed_loop
from tests import flights
from tests.members import array, built
from tests.oracles import reference_point
from tests.physics.test_guidance import WAY, H, length
from tests.short import CAMPAIGN

Array = NDArray[np.float64]


def tracked(sign: float = 1.0) -> Any:
    """A sample, and a reference point that moves in T."""
    one = jax.tree.map(jnp.asarray, flights.lane(flights.draw(flights.gains("pd-plus"), 300.0, 0.05), 0))
    zero = one.motion.rho.x * 0.0
    path = Reference(
        zero, *(Vector(*(jnp.asarray(sign * x) for x in a)) for a in ((3.0, 7.0, -5.0), (0.3, -0.2, 0.4), (0.02, 0.05, -0.03)))
    )
    return one, path


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_error_about_a_moving_point_falls_as_the_proof_of_pd_plus_says(sign: float) -> None:
    """V̇ = −k_ν|ν_c|² of V = ½k_ρ|ρ_c|² + ½|ν_c|², along the plant's rate and ṗ, p̈, for the known plant without limits. ρ_c and
    ν_c by NumPy's cross product. Kills: 2ω_t×ṗ or p̈ left out, ω_t×p with the other sign, a port that does not move."""
    one, path = tracked(sign)
    gains = Numbers({name: jnp.asarray(x) for name, x in flights.gains("pd-plus").items()})
    mass, moment = gains.mass_guess_kg, gains.inertia_guess_kgm2
    plant = one.plant._replace(mass=mass, inertia=Symmetric.of(moment, 0.0), inertia_inverse=Symmetric.of(1.0 / moment, 0.0))
    alpha_t = target_alpha(one.target.w, plant.target_inertia, plant.target_inertia_inverse)
    now = Measurement(path.t, one.motion, one.target, alpha_t, plant.port, one.upper, one.lower)
    nothing: Any = SimpleNamespace()
    wrench = pd_plus.respond(interface.followed(now, path), (), nothing, gains).command
    rate = motion_rate(one.motion, relative(one.motion, one.target, alpha_t, plant.port), plant, wrench)

    def about(motion: Motion, target: TargetMotion, p: Vector, v: Vector) -> tuple[Any, Any]:
        rows = rotation(motion.sigma)
        turn = jnp.array([row.parts() for row in (rows.a, rows.b, rows.c)])
        p_, v_, w_, rho, nu = (jnp.array(each.parts()) for each in (p, v, target.w, motion.rho, motion.nu))
        return rho - turn @ p_, nu - turn @ (jnp.cross(w_, p_) + v_)

    def energy(*state: Any) -> Any:
        rho, nu = about(*state)
        return 0.5 * gains.k_rho * rho @ rho + 0.5 * nu @ nu

    state = (one.motion, one.target, path.point, path.velocity)
    rates = (rate, target_rate(one.target, alpha_t), path.velocity, path.accel)
    _, falls = jax.jvp(energy, state, rates)
    _, nu = about(*state)
    assert float(falls) == pytest.approx(-float(gains.k_nu * nu @ nu), rel=1e-9)
    assert float(nu @ nu) > 0.01


SETS = (
    "samples=8", "faults=[]", "disturbances=[]", "require=[]", "guidance={use: corridor}", "correlate=[]",
    "audit={allow: [start]}",
    "target.inertia_kgm2={principal: [500, 550, 600]}", "target.rate_deg_s=[0.4, -0.5, 0.3]", "start.sigma={box: 0.4}",
)  # fmt: skip


@pytest.mark.usefixtures("bare")
def test_a_trace_has_the_reference_point_of_the_documentation(tmp_path: Path) -> None:
    """Every row against NumPy and SciPy to 1e-9, in a flight that goes round and waits for the attitude. Kills: any wrong term
    of the guidance, a situation of another instant, the true motion in the place of the measured one at t = 0."""
    sets = [*SETS, "controller={use: pd-plus, gains: {k_sigma: 0.002, k_omega: 0.09}}", "horizon.duration_s=260"]
    folder = run(CAMPAIGN, tmp_path / "run", sets, progress=False)
    port, inertia = np.array([5.0, 0.0, 0.0]), np.diag([500.0, 550.0, 600.0])
    parameters = corridor.Parameters()
    numbers = {name: quantity.parts[0].low for name, quantity in parameters.quantities().items()}
    waits = False
    for sample in range(3):
        trace: pd.DataFrame = replay(folder, sample)[0]
        point, velocity = reference_point.path(trace, port, port / 5.0, inertia, numbers)
        found = reference_point.columns(trace, "ref_*_m")
        np.testing.assert_allclose(found, point, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(reference_point.columns(trace, "ref_*_m_s"), velocity, rtol=0.0, atol=1e-9)
        turned = 4.0 * np.degrees(np.arctan(length(reference_point.columns(trace, "sigma_*"))))
        waits |= bool(np.any((turned > 10.0) & (found[:, 0] < 8.8) & (np.hypot(found[:, 1], found[:, 2]) < 0.8)))
    assert waits


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize(
    ("controller", "more"),
    [
        ("pd-plus", []),
        ("pd-plus", ["horizon.control_period_s=0.1"]),
        ("lqr-kalman", []),
        ("nominal-backstepping", ["navigation=[{use: noise, position_m: 0.005, velocity_m_s: 0.001}, {use: delay, steps: 2}]"]),
    ],
)
def test_controllers_follow_the_point(controller: str, more: list[str], tmp_path: Path) -> None:
    """Continuous, sampled, discrete-time, with errors of navigation: the pursuer stays near the reference point all the way,
    and comes near the docking point. Kills: a reference of another instant, a prediction that does not know p̈."""
    plant = ["pursuer.mass_kg=100", "pursuer.inertia_kgm2={principal: [21.7, 21.7, 21.7]}", "start.sigma={box: 0.05}"]
    sets = [*SETS, *plant, f"controller={{use: {controller}}}", "horizon.duration_s=300", *more]
    trace = replay(run(CAMPAIGN, tmp_path / "run", sets, progress=False), 1)[0]
    place = Rotation.from_mrp(reference_point.columns(trace, "sigma_*")).apply(reference_point.columns(trace, "rho_*_m"))
    lag = length(place - reference_point.columns(trace, "ref_*_m"))
    assert np.max(lag) < 0.3
    assert length(place)[0] > 10.0
    assert length(place)[-1] < 0.05


def test_the_point_s_numbers_can_be_differentiated() -> None:
    """At the very start, where the pursuer is at the point, and at the goal itself. Kills: the square root of 0."""
    one, path = tracked()
    for use in ("corridor", "waypoints"):
        said = {"points": [WAY[3]]} if use == "waypoints" else {}
        guidance, numbers = built("guidance", use, 1, **said)
        own = jax.tree.map(lambda x: jnp.asarray(x[0]), numbers)
        for place in (path.point, path.point * 0.0):
            alpha_t = one.motion.rho * 0.0
            still = Motion(rotate(rotation(one.motion.sigma), place), one.motion.nu, one.motion.sigma, one.motion.omega)
            seen = interface.Situation(path.t, still, one.target, alpha_t, one.plant.port, one.context.axis)

            def accel(own: Numbers, guidance: Any = guidance, seen: Any = seen) -> Any:
                memory = interface.started(guidance, seen, own)
                return interface.kept(guidance, Tick(0, path.t, jnp.asarray(H)), seen, memory, own).path.accel

            slopes = jax.jacfwd(accel)(own)
            assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(slopes))


def guided(use: str = "corridor", **said: Any) -> tuple[Any, Any]:
    """(closed loop of pd-plus, numbers of a sample)."""
    guidance, numbers = built("guidance", use, flights.LANES, **said)
    drawn = flights.draw(flights.gains("pd-plus"), 300.0, 0.05)._replace(guidance=numbers)
    return flights.loop("pd-plus")._replace(guidance=guidance), jax.tree.map(jnp.asarray, flights.lane(drawn, 0))


def test_within_a_step_the_controller_sees_the_point_of_the_instant() -> None:
    """The command at half a step is that for p + ṗτ + ½p̈τ² and ṗ + p̈τ, τ = h/2. Kills: a point that is held during a step,
    one of another instant, a controller that is not told of it."""
    loop, one = guided(gate_m=8, slope=0.3, acceleration=2.0)
    y, held = closed_loop.start(loop, one)
    _, _, held = closed_loop.evaluate(loop, one, 0.0, y, held, Tick(0, jnp.asarray(0.0), jnp.asarray(0.05)))
    path, half = held.guidance.path, 0.025
    assert float(jnp.linalg.norm(array(path.accel))) > 0.1
    _, step, _ = closed_loop.evaluate(loop, one, half, y, held)
    moved = Reference(half, path.point + path.velocity * half + path.accel * (0.5 * half * half),
                      path.velocity + path.accel * half, path.accel)  # fmt: skip
    now = closed_loop.measurement(half, y.motion, y.target, closed_loop.alpha(y.target, one.plant), one)
    nothing: Any = SimpleNamespace()
    expected = pd_plus.respond(interface.followed(now, moved), (), nothing, one.gains).command
    for ours, theirs in zip(step.command.parts(), expected.parts(), strict=True):
        assert float(ours) == pytest.approx(float(theirs), rel=1e-10, abs=1e-12)
    np.testing.assert_allclose(array(step.path.point), array(moved.point), atol=1e-12)


def test_a_user_s_controller_is_told_how_the_point_moves() -> None:
    """port_velocity and port_acceleration, 0 without guidance; port is the reference point. Kills: zeros where the point moves,
    one for the other."""
    one, path = tracked()
    now = closed_loop.measurement(path.t, one.motion, one.target, path.point * 0.0, one)
    told = Measured.of(interface.followed(now, path), unlimited, True)
    np.testing.assert_array_equal(told.port_velocity, array(path.velocity))
    np.testing.assert_array_equal(told.port_acceleration, array(path.accel))
    np.testing.assert_allclose(told.port, array(one.plant.port) + array(path.point))
    alone = Measured.of(now, unlimited, True)
    assert not np.any(alone.port_velocity) and not np.any(alone.port_acceleration)  # noqa: PT018
    np.testing.assert_array_equal(alone.port, array(one.plant.port))


def test_a_waypoint_waits_for_the_pursuer() -> None:
    """The reference point is there, the pursuer 1 m away, then 0.4 m: within_m is 0.5. Kills: a waypoint that looks at the
    point only, or at the pursuer's distance from the point; a point that leaves a pursuer behind."""
    guidance, numbers = built("guidance", "waypoints", 1, points=[{**WAY[3], "within_m": 0.5}, WAY[2]], lag_m=0.5)
    own = jax.tree.map(lambda x: jnp.asarray(x[0]), numbers)
    one, path = tracked()
    zero = path.point * 0.0
    there, begun = Reference(path.t, zero, zero, zero), waypoints.Progress(path.t, path.t + jnp.inf)

    def seen(*rho: float) -> interface.Situation:
        motion = one.motion._replace(rho=Vector(*map(jnp.asarray, rho)))
        return interface.Situation(path.t, motion, one.target, zero, one.plant.port, one.context.axis)

    for away, number in ((1.0, 0.0), (0.4, 1.0)):
        assert float(guidance.wanted(seen(0.0, away, 0.0), there, begun, own).kept.number) == number
    behind = guidance.wanted(seen(9.0, 0.0, 0.0), there._replace(point=path.point), begun, own)
    assert float(jnp.linalg.norm(array(behind.velocity))) == 0.0


def test_the_corridor_waits_for_the_pursuer() -> None:
    """Outside and in the axis, for a pursuer 9 m away from the point and one that is there. Kills: a point that leaves the
    pursuer behind."""
    guidance, numbers = built("guidance", "corridor", 1, gate_m=8)
    own = jax.tree.map(lambda x: jnp.asarray(x[0]), numbers)
    one, path = tracked()
    aligned = one.motion._replace(sigma=path.point * 0.0)
    for point in (one.context.axis * 4.0, path.point * 5.0):
        speeds: list[float] = []
        for off in (9.0, 0.0):
            motion = aligned._replace(rho=point + Vector(*map(jnp.asarray, (0.0, off, 0.0))))
            seen = interface.Situation(path.t, motion, one.target, path.point * 0.0, one.plant.port, one.context.axis)
            there = Reference(path.t, point, point * 0.0, point * 0.0)
            speeds.append(float(jnp.linalg.norm(array(guidance.wanted(seen, there, (), own).velocity))))
        assert speeds[0] < 1e-6
        assert speeds[1] > 0.1


@pytest.mark.parametrize("goal", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (0.6, 0, 0.8)])
def test_there_is_a_way_round_from_everywhere(goal: tuple[float, float, float]) -> None:
    """t is a unit vector across e that leads toward g, also exactly opposite to it. Kills: 0/0, or no way, there."""
    g = np.array(goal, float)
    beside = np.cross(g, [0.36, 0.48, 0.8])
    for angle in (1e-3, 1.0, 3.0, np.pi - 1e-2, np.pi - 1e-5, np.pi):
        e = np.cos(angle) * g + np.sin(angle) * beside / np.linalg.norm(beside) if angle < np.pi else -g
        t = array(corridor.tangent(*(Vector(*map(jnp.asarray, a)) for a in (e, g))))
        assert np.linalg.norm(t) == pytest.approx(1.0, abs=1e-9)
        assert abs(t @ e) < 1e-4
        assert t @ g > 0.0 or angle > 3.14
