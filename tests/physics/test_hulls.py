"""Distances of hulls, and collisions counted in flights, against closest points by least squares (SciPy) and plain NumPy."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.spatial.transform import Rotation as Turn

from rvjax.components.metrics import collision
from rvjax.components.registry import component
from rvjax.physics.dynamics import MU_EARTH
from rvjax.physics.hulls import Hull, Pose, least_distance, pose
from rvjax.physics.vectors import Rotation, Vector
from rvjax.simulation import jax_config, tables
from rvjax.simulation.batch import Flown, Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from tests import flights
from tests.physics.test_metric_members import scene

Array = np.ndarray[Any, Any]


class Body(NamedTuple):
    """centre: (n, 3). radius: of a ball; half: (n, 3) of a box. Each of n pairs."""

    centre: Array
    radius: Array
    half: Array | None

    def hull(self) -> Hull:
        """For the package."""
        half = () if self.half is None else Vector(*self.half.T)
        return Hull(Vector(*self.centre.T), self.radius, half)

    def row(self, i: int) -> tuple[Array, float, Array]:
        """A single body; a ball is a box of no size with a radius."""
        return self.centre[i], float(self.radius[i]), np.zeros(3) if self.half is None else self.half[i]


def bodies(generator: np.random.Generator, n: int, kind: str) -> Body:
    """n balls or boxes."""
    centre = generator.uniform(-0.5, 0.5, (n, 3))
    if kind == "ball":
        return Body(centre, generator.uniform(0.3, 2.0, n), None)
    return Body(centre, np.zeros(n), generator.uniform(0.1, 2.0, (n, 3)))


def distance(target: Body, pursuer: Body, i: int, place: Array, turn: Array) -> float:
    """Of two boxes by the nearest points, which are a bounded least-squares problem; balls are points with a radius. place: of
    the pursuer's frame in T; turn: R, T → P."""
    (c, r, h), (d, q, k) = target.row(i), pursuer.row(i)
    away = place + turn.T @ d - c
    sizes = np.concatenate([h, k])
    free = sizes > 0.0
    if not free.any():
        return float(np.linalg.norm(away)) - r - q
    matrix = np.hstack([np.eye(3), -turn.T])[:, free]
    found = lsq_linear(matrix, away, (-sizes[free], sizes[free]), method="bvls", tol=1e-14)
    return float(np.linalg.norm(matrix @ found.x - away)) - r - q


def poses(generator: np.random.Generator, n: int) -> tuple[Array, Array]:
    """Places 0 to 6 m away, and attitudes; every fourth is turned by a multiple of 90°, so that edges are parallel."""
    place = generator.normal(size=(n, 3))
    place *= generator.uniform(0.0, 6.0, (n, 1)) / np.linalg.norm(place, axis=1, keepdims=True)
    turn = Turn.random(n, random_state=generator).as_matrix()
    turn[::4] = np.round(Turn.from_euler("xyz", 90.0 * generator.integers(0, 4, (n, 3)), degrees=True).as_matrix())[::4]
    return place, turn


def package(target: Body, pursuer: Body, before: tuple[Array, Array], now: tuple[Array, Array]) -> Array:
    """least_distance of the package for all pairs."""
    ends: list[Pose] = []
    for place, turn in (before, now):
        r = Rotation(*(Vector(*turn[:, row].T) for row in range(3)))
        ends.append(pose(target.hull(), pursuer.hull(), Vector(*place.T), r))
    return np.asarray(least_distance(target.hull(), pursuer.hull(), *ends))


KINDS = [("ball", "ball"), ("ball", "box"), ("box", "ball"), ("box", "box")]
N = 400


@cache
def at_rest(kinds: tuple[str, str]) -> tuple[Array, Array]:
    """(bound of the package, distance) of N pairs."""
    generator = np.random.default_rng(5 + KINDS.index(kinds))
    target, pursuer = (bodies(generator, N, kind) for kind in kinds)
    place, turn = poses(generator, N)
    true = np.array([distance(target, pursuer, i, place[i], turn[i]) for i in range(N)])
    return package(target, pursuer, (place, turn), (place, turn)), true


@pytest.mark.parametrize("kinds", KINDS, ids="-".join)
def test_the_bound_at_rest(kinds: tuple[str, str]) -> None:
    """Never above the distance; equal with a ball. Kills: an edge in the place of half an edge, R for Rᵀ, a hull's centre left
    out or added with the wrong sign, a radius left out."""
    bound, true = at_rest(kinds)
    assert np.all(bound <= true + 1e-9)
    apart = true > 1e-9
    assert 100 < apart.sum() < N - 20
    if "ball" in kinds:
        np.testing.assert_allclose(bound[apart], true[apart], rtol=0.0, atol=1e-9)


def test_boxes_are_apart_or_not() -> None:
    """A gap is always seen, an overlap never taken for a gap; the bound of a gap is near to it. Kills: face normals of one box
    only, no cross products of edges, fewer projections."""
    bound, true = at_rest(("box", "box"))
    met = true < 1e-9
    assert met.sum() > 50
    assert np.all(bound[met] <= 1e-12)
    share = bound[~met] / true[~met]
    assert share.min() > 0.99, "a face normal alone sees 1/√3 of a gap"


@pytest.mark.parametrize("kinds", KINDS, ids="-".join)
def test_the_bound_between_two_instants(kinds: tuple[str, str]) -> None:
    """On a screw motion with a constant force, at 25 instants of a step in which the pursuer moves by its size. Kills: the larger
    of both ends, the direction at one end only."""
    n, step = 40, 1.0
    generator = np.random.default_rng(50)
    target, pursuer = (bodies(generator, n, kind) for kind in kinds)
    place, turn = poses(generator, n)
    velocity, pull = generator.uniform(-2.0, 2.0, (n, 3)), generator.uniform(-1.0, 1.0, (n, 3))
    rate = generator.normal(size=(n, 3))  # in P
    size = np.zeros(n) if pursuer.half is None else np.linalg.norm(pursuer.half, axis=1)
    reach = np.linalg.norm(pursuer.centre, axis=1) + pursuer.radius + size
    most = np.linalg.norm(pull, axis=1) + reach * np.sum(rate * rate, axis=1)

    def at(t: float) -> tuple[Array, Array]:
        return place + velocity * t + 0.5 * pull * t * t, Turn.from_rotvec(-rate * t).as_matrix() @ turn

    bound = package(target, pursuer, at(0.0), at(step)) - most * step * step / 8.0
    for t in np.linspace(0.0, step, 25):
        now = at(float(t))
        true = np.array([distance(target, pursuer, i, now[0][i], now[1][i]) for i in range(n)])
        assert np.all(bound <= true + 1e-9)


# Flights that collide on purpose: they start behind the target and fly straight to the docking point in front of it.
CAMPAIGN = """\
rvjax: 1
name: collisions
samples: 64
seed: 21
horizon: {duration_s: 40, step_s: 0.1}
target:
  orbit: {semi_major_axis_km: 6878}
  rate_deg_s: [0.6, -0.8, 0.4]
  port_m: [3, 0.5, 0]
  hull: TARGET
  keep_out: {radii_m: [5, 6, 4]}
pursuer:
  mass_kg: {uniform: [80, 120]}
  inertia_kgm2: {principal: [20, 22, 24]}
  centre_of_mass_m: [0.1, 0, {uniform: [-0.1, 0.1]}]
  hull: PURSUER
start:
  rho_m: [{uniform: [-14, -7]}, {uniform: [-3, 3]}, {uniform: [-3, 3]}]
  sigma: {box: 0.2}
  nu_m_s: [{uniform: [0.3, 0.9]}, {uniform: [-0.1, 0.1]}, {uniform: [-0.1, 0.1]}]
  omega_rad_s: {box: 0.05}
actuators: {upper: {force: 40, torque: 4}, lower: {force: 40, torque: 4}}
controller: {use: pd-plus}
corridor: {half_angle_deg: 15, radius_m: 0.4, length_m: 9}
capture: {window_s: 5}
"""
SHAPES = {
    "balls": ("{radius_m: 1.6, centre_m: [0, 0.2, 0]}", "{radius_m: 0.7, centre_m: [0.2, 0.1, 0]}"),
    "boxes": ("{box_m: [3, 2.4, 4], centre_m: [0, 0.2, 0]}", "{box_m: [0.8, 1.4, 1], centre_m: [0.2, 0.1, {uniform: [0, 0.2]}]}"),
}
FINER, MARGIN_M = 20, 0.02
"""The same flights at this part of the step. Distances this small are not compared: it is more than A h²/8 of every sample."""


class Flight(NamedTuple):
    """A row per sample. places, turns: (instants, samples, …) of the centre of mass in T, and R."""

    results: dict[str, Array]
    drawn: Any
    times: Array
    places: Array
    turns: Array


def flown(path: Path, step_s: float, *more: str, every: int = 1) -> Flight:
    """Flies the campaign and keeps every step, or every so many. more: overrides."""
    problem = load(path, [f"horizon.step_s={step_s!r}", *more])
    jax_config.configure("float64")
    count = problem.spec.samples
    _, drawn = Draws.of(problem, np.arange(count))
    came = Flyer.of(problem).fly(drawn, problem.spec.horizon.steps, every, trace=range(count))
    results = tables.outcomes(came, problem.spec.horizon.duration_s, problem.metrics)
    rho, sigma = (np.array([np.array(get(step).parts()).T for step in came.steps]) for get in (_rho, _sigma))
    turn = Turn.from_mrp(sigma.reshape(-1, 3)).inv().as_matrix().reshape(*sigma.shape, 3)
    port = np.array(drawn.plant.port.parts()).T
    places = np.einsum("tnji,tnj->tni", turn, rho) + port
    return Flight(results, drawn, np.array([step.t[0] for step in came.steps]), places, turn)


def _rho(step: Any) -> Any:
    return step.motion.rho


def _sigma(step: Any) -> Any:
    return step.motion.sigma


def smallest(flight: Flight) -> Iterator[tuple[float, Array]]:
    """Of each sample the smallest distance of its hulls over the instants [m], and the place there: instants are sorted by a
    coarse distance, the nearest ones are solved."""
    target, pursuer = (
        Body(np.array(h.centre.parts()).T, np.array(h.radius), np.array(h.half.parts()).T if h.half else None)
        for h in flight.drawn.context.hulls
    )
    pursuer = pursuer._replace(centre=pursuer.centre - np.array(flight.drawn.plant.centre.parts()).T)
    for i in range(flight.places.shape[1]):
        places, turns = flight.places[:, i], flight.turns[:, i]
        coarse = coarse_distance(target, pursuer, i, places, turns)
        near = np.unique(np.concatenate([np.argsort(coarse)[:3], [np.argmin(np.linalg.norm(places, axis=1))]]))
        found = {k: distance(target, pursuer, i, places[k], turns[k]) for k in near}
        k = min(found, key=lambda k: found[k])
        yield found[k], places[k]


def coarse_distance(target: Body, pursuer: Body, i: int, places: Array, turns: Array) -> Array:
    """Of a sample at every instant, from above: between two points that are found by projecting forth and back."""
    (c, r, h), (d, q, k) = target.row(i), pursuer.row(i)
    away = places + np.einsum("tji,j->ti", turns, d) - c
    theirs, ours = away, away
    for _ in range(50):
        ours = np.clip(theirs, -h, h)
        seen = np.clip(np.einsum("tij,tj->ti", turns, ours - away), -k, k)
        theirs = away + np.einsum("tji,tj->ti", turns, seen)
    return np.linalg.norm(theirs - ours, axis=1) - r - q


@pytest.fixture(scope="module", params=SHAPES)
def coarse(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Flight]:
    """The campaign, and its flights."""
    target, pursuer = SHAPES[request.param]
    path = tmp_path_factory.mktemp("collisions") / "campaign.yaml"
    path.write_text(CAMPAIGN.replace("TARGET", target).replace("PURSUER", pursuer))
    return path, flown(path, 0.1)


def test_collisions_are_counted_to_the_sample(coarse: tuple[Path, Flight]) -> None:
    """Which flights collide, at a twentieth of the step with every step checked. Kills: a hull that does not follow the centre of
    mass, the body's axes for T's, a clearance from the last step only, a collision that is not an outcome."""
    path, flight = coarse
    true, _ = zip(*smallest(flown(path, 0.1 / FINER)), strict=True)
    true = np.array(true)
    collided = flight.results["outcome"] == "collided"
    clearance = flight.results["metric.hull_clearance_m"]
    assert np.array_equal(collided, clearance <= 0.0)
    sure = np.abs(true) > MARGIN_M
    boxes_meet = true > -1e-9  # least squares give no depth: overlapping boxes are at 0
    sure |= (true < 1e-7) & boxes_meet
    assert np.array_equal(collided[sure], true[sure] < 1e-7)
    assert (~sure).sum() == 0, "with this seed no flight is this near to a contact"
    assert 12 < collided.sum() < 52
    apart = ~collided
    assert np.all(clearance[apart] <= true[apart] + 1e-4), "but for the error of the integration"
    seen = 1.0 if path.read_text().count("radius_m: ") > 2 else 0.57  # the corridor has a radius too
    assert np.all(clearance[apart] > seen * true[apart] - MARGIN_M)


def test_a_collision_has_its_time_its_place_and_its_speed(coarse: tuple[Path, Flight]) -> None:
    """Kills: the last contact for the first, the inertial velocity, a place from another origin."""
    _, flight = coarse
    for i, (outcome, time, speed) in enumerate(
        zip(*(flight.results[name] for name in ("outcome", "outcome_time_s", "metric.collision_speed_m_s")), strict=True)
    ):
        if outcome != "collided":
            assert speed == 0.0
            assert flight.results["metric.collision_time_s"][i] == np.inf
            continue
        assert flight.results["metric.collision_time_s"][i] == time
        k = int(np.argmin(np.abs(flight.times - time)))
        moved = np.linalg.norm(flight.places[k + 1, i] - flight.places[k - 1, i]) / 0.2
        assert speed == pytest.approx(moved, abs=0.01)
        assert np.isnan(flight.results["metric.window_position_error_m"][i])
        assert flight.results["metric.captured"][i] == 0.0
    found = list(smallest(flight))
    axis = np.array(flight.drawn.context.axis.parts()).T
    port = np.array(flight.drawn.plant.port.parts()).T
    for i, (true, place) in enumerate(found):
        if true > MARGIN_M:
            away = place - port[i]
            along = away @ axis[i]
            lateral = np.linalg.norm(away - along * axis[i])
            assert flight.results["metric.closest_axial_m"][i] == pytest.approx(along, abs=0.35)
            assert flight.results["metric.closest_lateral_m"][i] == pytest.approx(lateral, abs=0.35)


def test_times_in_the_zone_and_outside_of_the_corridor(coarse: tuple[Path, Flight]) -> None:
    """From the places of every step. Kills: the cone's apex at the docking point or in front of it, a corridor without an end,
    half an axis for the axis of the ellipsoid, time in the zone inside the cone."""
    _, flight = coarse
    weights = np.full(len(flight.times), 0.1)
    weights[[0, -1]] *= 0.5
    port, axis = (np.array(v.parts()).T for v in (flight.drawn.plant.port, flight.drawn.context.axis))
    rho = flight.places - port
    away = np.linalg.norm(rho, axis=2)
    along = np.einsum("tni,ni->tn", rho, axis)
    across = np.linalg.norm(rho - along[..., None] * axis, axis=2)
    outside = across > (along + 0.4 / np.tan(np.radians(15.0))) * np.tan(np.radians(15.0))
    counts = outside & (away > 0.01)
    in_zone = np.sum((flight.places / [5.0, 6.0, 4.0]) ** 2, axis=2) < 1.0
    expected = {"corridor_violation_s": counts & (away <= 9.0), "keep_out_violation_s": counts & in_zone}
    for name, on in expected.items():
        np.testing.assert_allclose(flight.results[f"metric.{name}"], weights @ on, rtol=0.0, atol=1e-9)
        assert np.unique(weights @ on).size > 20


def test_the_clearance_has_a_derivative() -> None:
    """Also where centres coincide and hulls are centred. Kills: the root of a number that may be 0."""

    def clearance(x: Any) -> Any:
        target = Hull(Vector(0.0, 0.0, 0.0), 0.0, Vector(1.0, 1.0, 1.0))
        pursuer = Hull(Vector(0.0, 0.0, 0.0), 0.0, Vector(0.5, 0.5, 0.5))
        r = Rotation(Vector(1.0, 0.0, 0.0), Vector(0.0, 1.0, 0.0), Vector(0.0, 0.0, 1.0))
        at = pose(target, pursuer, Vector(x, 0.0 * x, 0.0 * x), r)
        return least_distance(target, pursuer, at, at)

    for x, slope in ((3.0, 1.0), (0.5, 1.0), (-3.0, -1.0)):
        value, found = jax.jvp(clearance, (x,), (1.0,))
        assert float(value) == pytest.approx(abs(x) - 1.5)
        assert float(found) == pytest.approx(slope)
    assert np.isfinite(jax.jvp(clearance, (0.0,), (1.0,))[1])

    def of_balls(x: Any) -> Any:
        ball = Hull(Vector(0.0 * x, 0.0 * x, 0.0 * x), 1.0)
        r = Rotation(Vector(1.0, 0.0, 0.0), Vector(0.0, 1.0, 0.0), Vector(0.0, 0.0, 1.0))
        at = pose(ball, ball, Vector(x, 0.0 * x, 0.0 * x), r)
        return least_distance(ball, ball, at, at) + ball.reach

    value, found = jax.jvp(of_balls, (0.0,), (1.0,))
    assert float(value) == pytest.approx(-1.0)
    assert np.isfinite(found)


def test_nothing_is_stepped_over(tmp_path: Path) -> None:
    """A fast pursuer passes a small ball within one step of 2 s, and turns about on its way there: at the steps it is far away.

    Kills: no bound between the steps, or a bound that is too high.
    """
    path = tmp_path / "campaign.yaml"
    text = CAMPAIGN.replace("hull: TARGET", "hull: {radius_m: 0.3}").replace("hull: PURSUER", "hull: {radius_m: 0.2}")
    path.write_text(text.replace("step_s: 0.1}", "step_s: 2}").replace("window_s: 5", "window_s: 6"))
    said = [
        "samples=4", "target.rate_deg_s=0", "start.sigma=0", "start.omega_rad_s=0", "pursuer.centre_of_mass_m=0",
        "target.port_m=[3, 0, 0]", "actuators.upper=0.5", "actuators.lower=0.5", "target.keep_out=null",
    ]  # fmt: skip
    for start, speed, meets in (("[-6, 0, 0]", "[3, 0, 0]", True), ("[-6, 1, 0]", "[3, 0, 0]", False)):
        problem = load(path, [*said, f"start.rho_m={start}", f"start.nu_m_s={speed}"])
        jax_config.configure("float64")
        _, drawn = Draws.of(problem, np.arange(4))
        came = Flyer.of(problem).fly(drawn, problem.spec.horizon.steps, 1, trace=range(4))
        outcome = tables.outcomes(came, problem.spec.horizon.duration_s, problem.metrics)["outcome"]
        places = np.array([np.array(step.motion.rho.parts()).T for step in came.steps]) + np.array([3.0, 0.0, 0.0])
        assert np.linalg.norm(places[:3], axis=2).min() > 1.0
        assert set(outcome) == ({"collided"} if meets else {"not_settled"})


def test_the_bound_of_the_acceleration() -> None:
    """A = 2a of two equal instants, by NumPy. Kills: a term left out, a power, a factor; the bound added for subtracted."""
    step, context = scene()
    centre = Vector(*(step.plant.mass * 0.0 + part for part in (0.1, -0.2, 0.15)))
    step = step._replace(plant=step.plant._replace(centre=centre))
    target, pursuer = context.hulls
    h = np.asarray(context.step_s)

    def clearance(updates: int) -> Array:
        def folded(one: Any, given: Any) -> Any:
            acc = collision.start(given)
            for _ in range(updates):
                acc = collision.update(acc, one, given.step_s, given)
            return acc.clearance

        return np.asarray(jax.vmap(folded)(step, context))

    plant, size = step.plant, np.linalg.norm

    def rows(vector: Any) -> Array:
        return np.array([np.asarray(part) for part in vector.parts()]).T

    turns = Turn.from_mrp(rows(step.motion.sigma)).as_matrix()  # P → T
    w, omega, most, total = rows(step.target.w), rows(step.motion.omega), plant.upper, step.total
    inertia, inverse = ((np.asarray(j.xx + j.yy + j.zz)) for j in (plant.inertia, plant.inertia_inverse))
    rho = np.einsum("nij,nj->ni", turns, rows(step.motion.rho))
    x, v = rho + rows(plant.port), np.einsum("nij,nj->ni", turns, rows(step.motion.nu)) - np.cross(w, rho)
    own = np.einsum("nji,nj->ni", turns, w)
    j = np.moveaxis(np.array(flights.matrix(plant.target_inertia)), -1, 0)
    swing = size(np.linalg.solve(j, np.cross(w, np.einsum("nij,nj->ni", j, w))[..., None])[..., 0], axis=1)
    f, tau, u, u_tau = (size(rows(part), axis=1) for part in (total.force, total.torque, most.force, most.torque))
    turn, spin = size(w, axis=1), size(omega, axis=1)
    lever = u_tau + size(rows(centre), axis=1) * u + tau + inertia * size(omega + own, axis=1) ** 2
    alpha = inverse * lever + spin * turn + swing
    reach = size(rows(pursuer.centre) - rows(centre), axis=1) + np.asarray(pursuer.radius)
    tide = 2.0 * MU_EARTH * size(x, axis=1) / size(rows(step.target.r), axis=1) ** 3
    a = (u + f) / np.asarray(plant.mass) + tide + 2.0 * turn * size(v, axis=1) + (turn**2 + swing) * size(x, axis=1)
    a = a + reach * (spin**2 + alpha)
    np.testing.assert_allclose(clearance(1) - clearance(2), 2.0 * a * h**2 / 8.0, rtol=1e-9)
    box = Body(rows(target.centre), np.asarray(target.radius), rows(target.half))
    ball = Body(rows(pursuer.centre) - rows(centre), np.asarray(pursuer.radius), None)
    true = [distance(box, ball, i, x[i], turns[i].T) for i in range(len(x))]
    np.testing.assert_allclose(clearance(1), true, rtol=1e-9)


def test_the_first_that_holds_is_the_outcome() -> None:
    """Captured, never settled, lost, collided; collided and captured all the same, lost after a collision, lost before it could
    be one. Kills: a collision that a capture makes good, metrics of what follows a collision, one of a flight that is lost."""
    inf, nan = np.inf, np.nan
    values = {
        "captured": np.array([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
        "settling_time_s": np.array([5.0, inf, nan, 8.0, 6.0, nan, nan]),
        "attitude_settling_time_s": np.array([4.0, 3.0, nan, 8.0, 7.0, nan, nan]),
        "collision_time_s": np.array([inf, inf, inf, 3.0, 2.0, 4.0, 9.0]),
        "hull_clearance_m": np.array([1.0, 2.0, nan, -0.1, -0.2, -0.3, nan]),
    }
    lost = np.array([inf, inf, 6.0, inf, inf, 5.0, 8.0])
    came = Flown(values=values, lost_s=lost, envelope=[], steps=[], means=[])
    found = tables.outcomes(came, 10.0, (component("metrics", "tubes"), component("metrics", "collision")))
    words = ["captured", "not_settled", "not_finite", "collided", "collided", "collided", "not_finite"]
    assert found["outcome"].tolist() == words
    assert found["outcome_time_s"].tolist() == [5.0, 10.0, 6.0, 3.0, 2.0, 4.0, 8.0]
    np.testing.assert_array_equal(found["metric.captured"], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(found["metric.settling_time_s"], [5.0, inf, nan, nan, nan, nan, nan])
    np.testing.assert_array_equal(found["metric.hull_clearance_m"], [1.0, 2.0, nan, -0.1, -0.2, -0.3, nan])
