"""Guidance: the reference point against its limits and an independent re-enactment, and the controllers that follow it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rvjax.components.controllers import pd_plus
from rvjax.components.guidance import corridor, interface
from rvjax.execution.replay import replay
from rvjax.execution.run import run
from rvjax.physics.dynamics import MU_EARTH, motion_rate, relative, target_alpha, target_rate
from rvjax.physics.state import Measurement, Motion, Numbers, TargetMotion, Tick
from rvjax.physics.state import Path as Reference
from rvjax.physics.vectors import Symmetric, Vector, rotate, rotation
from rvjax.simulation import rk4
from tests import flights
from tests.members import array, built
from tests.oracles import reference_point
from tests.short import CAMPAIGN

Array = NDArray[np.float64]

INERTIA = Symmetric(400.0, 550.0, 650.0, 0.0, 0.0, 0.0)
INVERSE = Symmetric(1 / 400.0, 1 / 550.0, 1 / 650.0, 0.0, 0.0, 0.0)
FASTEST = np.radians(3.0)
SAMPLES, H = 64, 0.1


class Lead(NamedTuple):
    """What the reference point did, in T: (samples, steps, 3). port, axis: (samples, 3)."""

    point: Array
    velocity: Array
    accel: Array
    r: Array
    v: Array
    w: Array
    port: Array
    axis: Array

    @property
    def place(self) -> Array:
        """q, from the target's centre."""
        return self.point + self.port[:, None]

    @property
    def along(self) -> Array:
        """(samples, steps) x."""
        return np.einsum("nki,ni->nk", self.point, self.axis)

    @property
    def beside(self) -> Array:
        """(samples, steps) |l|."""
        return np.linalg.norm(self.point - self.axis[:, None] * self.along[..., None], axis=-1)


def vectors(a: Array) -> Vector:
    return Vector(*np.asarray(a, float).T)


def units(generator: np.random.Generator, count: int = SAMPLES) -> Array:
    a = generator.normal(size=(count, 3))
    return a / np.linalg.norm(a, axis=1, keepdims=True)


def tumbling(t: Any, target: TargetMotion) -> TargetMotion:
    """Rate of the target."""
    del t
    return target_rate(target, target_alpha(target.w, INERTIA, INVERSE))


def led(use: str, seconds: float, turned_s: float = -1.0, places: Any = None, rate: Array | None = None,
        seed: int = 1, **said: Any) -> Lead:  # fmt: skip
    """The reference point of a pursuer that is always where the point is, from random places at rest in LVLH about targets that
    tumble with up to FASTEST. turned_s: until then the pursuer is 60° off its attitude."""
    generator = np.random.default_rng(seed)
    guidance, numbers = built("guidance", use, SAMPLES, **said)
    w = units(generator) * generator.uniform(0.0, FASTEST, (SAMPLES, 1)) if rate is None else rate
    port = units(generator) * generator.uniform(1.0, 6.0, (SAMPLES, 1))
    axis = port / np.linalg.norm(port, axis=1, keepdims=True) + 0.3 * units(generator)
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    q = units(generator) * generator.uniform(20.0, 80.0, (SAMPLES, 1)) if places is None else places(port, axis)
    turn = Rotation.random(SAMPLES, generator).inv()
    speed = np.sqrt(MU_EARTH * 1.1 / 6.8e6)
    r, v = turn.apply([6.8e6, 0.0, 0.0]), turn.apply([0.0, speed, 0.0])
    still = np.cross(np.cross(r, v) / np.sum(r * r, axis=1, keepdims=True) - w, q)
    motion = Motion(vectors(q - port), vectors(still + np.cross(w, q - port)), vectors(q * 0.0), vectors(q * 0.0))

    def one(own: Numbers, target: TargetMotion, port: Vector, axis: Vector, motion: Motion) -> Any:
        def known(t: Any, target: TargetMotion, motion: Motion) -> interface.Situation:
            return interface.Situation(t, motion, target, target_alpha(target.w, INERTIA, INVERSE), port, axis)

        def step(carry: Any, k: Any) -> Any:
            target, memory = carry
            path = memory.path.at(k * H)
            sigma = Vector(jnp.where(k * H < turned_s, np.tan(np.radians(15.0)), 0.0), path.point.x * 0.0, path.point.x * 0.0)
            seen = Motion(rotate(rotation(sigma), path.point), path.velocity, sigma, path.point * 0.0)
            memory = interface.kept(guidance, Tick(k, k * H, jnp.asarray(H)), known(k * H, target, seen), memory, own)
            return (rk4.step(tumbling, k * H, target, H, tumbling(0.0, target)), memory), (memory.path, target)

        begun = interface.started(guidance, known(0.0 * port.x, target, motion), own)
        return jax.lax.scan(step, (target, begun), jnp.arange(round(seconds / H)))[1]

    inputs = (numbers, TargetMotion(vectors(r), vectors(v), vectors(w)), vectors(port), vectors(axis), motion)
    path, target = jax.jit(jax.vmap(one))(*jax.tree.map(jnp.asarray, inputs))
    values = (path.point, path.velocity, path.accel, target.r, target.v, target.w)
    return Lead(*map(array, values), port, axis)


def length(a: Array) -> Array:
    return np.linalg.norm(a, axis=-1)


def at_random() -> Lead:
    return led("corridor", gate_m=8, seconds=500.0)


@pytest.fixture(scope="module")
def approach() -> Lead:
    """Random approaches by the corridor."""
    return at_random()


def in_axis(lead: Lead, gate: float = 8.0) -> NDArray[np.bool_]:
    """(samples, steps) whether the point is in the axis."""
    return (lead.beside <= 0.1 * lead.along + 0.02) & (lead.along <= 1.1 * gate)


def test_the_point_moves_without_jumps(approach: Lead) -> None:
    """Place and velocity at the end of a step are those at the beginning of the next. Kills: a path that restarts, ½ left out."""
    p, v, a = approach.point, approach.velocity, approach.accel
    np.testing.assert_allclose(p[:, 1:], (p + H * v + 0.5 * H * H * a)[:, :-1], atol=1e-12)
    np.testing.assert_allclose(v[:, 1:], (v + H * a)[:, :-1], atol=1e-12)


def test_the_point_stays_outside_until_it_is_in_the_axis(approach: Lead) -> None:
    """From random places about targets that tumble with up to 3°/s, it is never nearer to the target than the gate before it is
    in the axis; it comes into the axis, stays there and ends at the docking point. Kills: going round before it is at rest
    relative to the target, a turning that is taken on without its acceleration, radial speed of the wrong sign."""
    inside = in_axis(approach)
    gate = length(approach.port + 8.0 * approach.axis)
    assert inside[:, -1].all()
    entered = np.argmax(inside, axis=1)
    before = np.arange(inside.shape[1]) < entered[:, None]
    assert np.all(np.where(before, length(approach.place), np.inf) > gate[:, None])
    assert np.all(inside | before)
    assert np.max(length(approach.point[:, -1])) < 1e-3
    assert np.all((np.diff(approach.along, axis=1) < 1e-9) | before[:, 1:] | np.roll(before, 50, axis=1)[:, 1:])


def test_the_point_keeps_its_limits(approach: Lead) -> None:
    """In the axis the frame is T: |p̈| ≤ a and −ẋ ≤ v, and near the docking point v ≤ max(κx, v_end). Kills: a limit that is left
    out, a profile that the point cannot brake on."""
    inside = in_axis(approach)
    late = inside & np.roll(inside, 50, axis=1)
    assert np.max(length(approach.accel)[inside]) <= 0.02 * (1.0 + 1e-9)
    speed = -np.einsum("nki,ni->nk", approach.velocity, approach.axis)
    assert np.max(speed[late]) <= 0.2 + 1e-9
    room = np.maximum(0.05 * approach.along, 0.02)
    assert np.max((speed - room)[late]) < 0.25 * 0.2
    near = late & (approach.along < 1.0)
    assert np.max((speed - room)[near]) < 5e-3


def test_far_away_the_point_is_at_rest_in_lvlh() -> None:
    """It comes down along a line that is fixed in LVLH, by a computation from r and v alone. Kills: rest in T or in inertial
    space, ċ left out, the sign of c."""
    far = led("corridor", gate_m=8, seconds=60.0, places=lambda port, axis: 70.0 * units(np.random.default_rng(7)))
    e = in_lvlh(far) / length(far.place)[..., None]
    assert np.max(length(e - e[:, :1])) < 2e-3  # p̈ is held during a step, while c×(c×q) turns
    assert np.all(length(far.place)[:, -1] < length(far.place)[:, 0] - 15.0)


def in_lvlh(lead: Lead) -> Array:
    """(samples, steps, 3) q in LVLH."""
    z = -lead.r / length(lead.r)[..., None]
    h = np.cross(lead.r, lead.v)
    y = -h / length(h)[..., None]
    return np.stack([np.sum(axis * lead.place, axis=-1) for axis in (np.cross(y, z), y, z)], axis=-1)


@pytest.mark.parametrize("off", [0.0, 1e-4])
def test_a_start_behind_the_target_goes_round(off: float) -> None:
    """Exactly opposite to the gate, about a target at rest. Kills: 0/0 there, a point that stays, one that takes the line through
    the target for the axis."""

    def opposite(port: Array, axis: Array) -> Array:
        gate = port + 1.05 * 8.0 * axis
        return -2.0 * gate + off * np.cross(port, axis)

    behind = led("corridor", gate_m=8, seconds=400.0, places=opposite, rate=np.zeros((SAMPLES, 3)))
    on_axis = led("corridor", gate_m=8, seconds=400.0, places=lambda port, axis: port - 40.0 * axis, rate=np.zeros((SAMPLES, 3)))
    for lead in (behind, on_axis):
        gate = length(lead.port + 8.0 * lead.axis)
        inside = in_axis(lead)
        assert np.all(np.where(np.cumsum(inside, axis=1) == 0, length(lead.place), np.inf) > gate[:, None])
        assert np.max(length(lead.point[:, -1])) < 1e-2


def test_the_point_waits_for_a_pursuer_that_is_not_aligned() -> None:
    """60° off until t = 400 s: it stands in the axis, no nearer than the gate less what it brakes on, and goes on afterwards.
    Kills: a point that does not look at the attitude, one that goes back."""
    waiting = led("corridor", gate_m=8, seconds=560.0, turned_s=400.0, rate=np.full((SAMPLES, 3), 0.004))
    at = round(399.0 / H)
    assert in_axis(waiting)[:, at].all()
    assert np.all(waiting.along[:, at] > 8.0)
    assert np.max(length(waiting.velocity[:, at])) < 5e-3
    assert np.max(length(waiting.point[:, -1])) < 1e-2


WAY = [
    {"frame": "lvlh", "at_m": [-40, 5, 0], "speed_m_s": 0.4, "hold_s": 30, "within_m": 0.2},
    {"frame": "lvlh", "at_m": [-20, 0, -10], "speed_m_s": 0.3, "within_m": 0.3},
    {"frame": "port", "at_m": [8, 1, -1], "speed_m_s": 0.2, "hold_s": 5, "within_m": 0.1},
    {"frame": "port", "at_m": [0, 0, 0], "speed_m_s": 0.1},
]


def test_waypoints_are_passed_in_their_order() -> None:
    """Each is held as long as it says: those of LVLH stand still there, those of the port in T. Kills: an order that is not
    kept, a clock that starts too early, LVLH without its rate, ċ left out, axes of the port that are turned."""
    w = units(np.random.default_rng(3)) * np.radians(1.0)
    lead = led("waypoints", 1100.0, rate=w, points=WAY)
    placed = in_lvlh(lead)
    turn = [Rotation.align_vectors([n], [[1.0, 0.0, 0.0]])[0] for n in lead.axis]
    goal = np.array([each.apply([8.0, 1.0, -1.0]) for each in turn])[:, None]
    at = [
        length(placed - WAY[0]["at_m"]) < 0.2,
        length(placed - WAY[1]["at_m"]) < 0.3,
        length(lead.point - goal) < 0.1,
        length(lead.point) < 0.05,
    ]
    reached = np.array([np.argmax(each, axis=1) for each in at])
    assert all(each.any(axis=1).all() for each in at)
    assert np.all(np.diff(reached, axis=0) > 0)
    for each, hold in ((0, 30.0), (2, 5.0)):
        steps = round(hold / H)
        assert all(at[each][k, first : first + steps].all() for k, first in enumerate(reached[each]))
    held = reached[0] + round(29.0 / H)
    drift = [np.max(length(np.diff(placed[k, last - 20 : last], axis=0))) for k, last in enumerate(held)]
    assert np.max(drift) < 0.01 * H


def test_a_waypoint_of_lvlh_is_held_still() -> None:
    """About a target that tumbles with 3°/s, 50 m away, where T itself needs 0.14 m/s². Kills: a limit of the acceleration in
    T."""
    w = FASTEST * units(np.random.default_rng(4))
    lead = led("waypoints", 700.0, rate=w, points=[{"frame": "lvlh", "at_m": [-50, 0, 0], "speed_m_s": 0.4}])
    placed = in_lvlh(lead)[:, -100:]
    assert np.max(length(placed - [-50.0, 0.0, 0.0])) < 1e-2
    assert np.max(np.ptp(placed, axis=1)) < 3e-3


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
        said = {"points": WAY} if use == "waypoints" else {}
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
