"""Guidance: the reference point against its limits and an independent re-enactment, and the controllers that follow it."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rvjax.components.guidance import interface
from rvjax.physics.dynamics import MU_EARTH, target_alpha, target_rate
from rvjax.physics.state import Motion, Numbers, TargetMotion, Tick
from rvjax.physics.vectors import Symmetric, Vector, rotate, rotation
from rvjax.simulation import rk4
from tests.members import array, built

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


def test_a_steep_profile_is_flattened() -> None:
    """With κ, v and v_far for which the point could not brake. Kills: a slope above 1/(4T), a speed above a/κ: the point would
    swing through the docking point, or below the distance of the gate."""
    steep = led("corridor", gate_m=8, slope=1.0, speed_m_s=9, far_speed_m_s=9, end_speed_m_s=9, acceleration=0.3, seconds=200.0)
    inside = in_axis(steep)
    gate = length(steep.port + 8.0 * steep.axis)
    assert np.all(np.where(np.cumsum(inside, axis=1) == 0, length(steep.place), np.inf) > gate[:, None])
    assert np.min(np.where(inside, steep.along, np.inf)) > -1e-6
    assert np.max(length(steep.point[:, -1])) < 1e-2
