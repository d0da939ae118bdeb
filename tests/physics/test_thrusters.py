"""Thrusters: what layouts can give, against the facets of the zonotope; allocation, against SciPy's bounded least squares."""

from __future__ import annotations

import itertools
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from rvjax.campaign.thruster_layout import LAYOUTS, Layout, cube, limits, margins, pinwheel, rank
from rvjax.columns import CHANNELS
from rvjax.physics.state import Step, Tick
from rvjax.physics.thruster_allocation import EPSILON, bounded_least_squares, pseudo_inverse, wrench
from rvjax.physics.vectors import Channels, Thrusts
from rvjax.simulation import closed_loop
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem, load
from rvjax.simulation.tables import trace_tables
from tests.short import CAMPAIGN

Array = NDArray[np.float64]


def crooked(count: int = 11, seed: int = 10) -> Layout:
    """Places, directions and sizes without any symmetry, and limits that are other ones on either side."""
    generator = np.random.default_rng(seed)
    along = generator.normal(size=(count, 3))
    along /= np.linalg.norm(along, axis=1)[:, None]
    at = generator.uniform(-0.8, 0.8, (count, 3))
    return Layout(tuple(map(tuple, at)), tuple(map(tuple, along)), tuple(generator.uniform(0.5, 1.5, count)))


ALL = {"cube-24": cube(1.0, 1.2), "pinwheel-12": pinwheel(0.7, 2.0), "crooked": crooked()}


@cache
def facets(name: str) -> tuple[Array, Array, Array]:
    """(m, 5) thrusters, (m, 6) normals and (m, N) positive parts dᵀbᵢ fᵢ of their sums, of every facet of the attainable set.

    A facet is spanned by five columns; its support is h(d) = Σ max(0, dᵀbᵢ) fᵢ, which is exact.
    """
    layout = ALL[name]
    columns = matrix(layout) * np.array(layout.most)
    chosen = np.array(list(itertools.combinations(range(columns.shape[1]), 5)))
    spanned = columns.T[chosen]
    minors = [np.linalg.det(np.delete(spanned, row, axis=2)) * (-1.0) ** row for row in range(6)]
    normals = np.stack(minors, axis=-1)
    size = np.abs(normals).max(axis=1)
    real = size > 1e-9 * size.max()
    normals, chosen = normals[real] / size[real, None], chosen[real]
    both = np.concatenate([normals, -normals])
    return np.concatenate([chosen, chosen]), both, np.maximum(both @ columns, 0.0)


def matrix(layout: Layout) -> Array:
    """B, from forces and torques one by one."""
    at, along = np.array(layout.at), np.array(layout.along)
    torque = [np.array([y * c - z * b, z * a - x * c, x * b - y * a]) for (x, y, z), (a, b, c) in zip(at, along, strict=True)]
    return np.concatenate([along, np.array(torque)], axis=1).T


def reach(normals: Array, support: Array) -> Array:
    """(12,) the largest λ with ± λ e inside: min h(d)/(± d e) over the facets that look this way."""
    ends: list[float] = []
    for sign, channel in itertools.product((1.0, -1.0), range(6)):
        ahead = sign * normals[:, channel]
        faces = ahead > 1e-9
        ends.append(float(np.min(support[faces] / ahead[faces])))
    return np.array(ends)


@pytest.mark.parametrize("name", ALL)
def test_limits_are_those_of_the_zonotope(name: str) -> None:
    """Kills: the largest force whatever the torque, limits of one side for both, at × −along, the wrong axis of a thruster."""
    _, normals, positive = facets(name)
    np.testing.assert_allclose(np.concatenate(limits(ALL[name])), reach(normals, positive.sum(axis=1)), rtol=1e-9)


@pytest.mark.parametrize("name", ALL)
def test_margins_are_those_of_the_zonotope_without_one(name: str) -> None:
    """Kills: a mean over the channels, the sound limits, a thruster beside the lost one."""
    chosen, normals, positive = facets(name)
    sound = reach(normals, positive.sum(axis=1))
    found = margins(ALL[name])
    assert [margin.lost for margin in found] == [f"t{index + 1}" for index in range(len(ALL[name].most))]
    for lost, margin in enumerate(found):
        kept = (chosen != lost).all(axis=1)
        shares = reach(normals[kept], np.delete(positive[kept], lost, axis=1).sum(axis=1)) / sound
        assert margin.share == pytest.approx(min(shares.min(), 1.0), abs=1e-9)
        side = "+-".index(margin.channel[0]) * 6 + CHANNELS.index(margin.channel[1:])
        assert shares[side] == pytest.approx(shares.min(), abs=1e-9)
        assert margin.rank == np.linalg.matrix_rank(np.delete(matrix(ALL[name]), lost, axis=1), tol=1e-9)


def test_the_named_layouts_give_what_their_chapter_says() -> None:
    """Kills: half an edge for an edge, three thrusters in one direction, a thruster that is there twice."""
    for size, most in ((1.0, 1.2), (0.4, 3.0)):
        upper, lower = limits(LAYOUTS["cube-24"](size, most))
        np.testing.assert_allclose([upper, lower], [[4 * most] * 3 + [4 * size * most] * 3] * 2, rtol=1e-12)
        upper, lower = limits(LAYOUTS["pinwheel-12"](size, most))
        np.testing.assert_allclose([upper, lower], [[2 * most] * 3 + [size * most] * 3] * 2, rtol=1e-12)
    for layout in (cube(1.0, 1.0), pinwheel(1.0, 1.0)):
        places = list(zip(layout.at, layout.along, strict=True))
        assert len(set(places)) == len(places)
        assert all(np.dot(at, along) < 0.0 for at, along in places)  # it pushes inwards, the plume goes outwards


def test_rank_and_control_are_told_apart() -> None:
    """Kills: rank alone, a rank that a scale of metres decides, a limit out of rounding."""
    layout = cube(1.0, 1.0)
    flat = Layout(layout.at, tuple((x, y, 0.0) for x, y, _ in layout.along), layout.most)
    assert rank(layout) == rank(cube(1e-9, 1.0)) == 6
    assert rank(flat) == 5
    assert min(limits(flat)[0]) == 0.0
    pushing = Layout(layout.at, tuple((x, y, abs(z)) for x, y, z in layout.along), layout.most)
    assert rank(pushing) == 6
    upper, lower = limits(pushing)
    assert lower[2] == 0.0  # all eight push up
    assert upper[2] == pytest.approx(8.0)


def wrenches(layout: Layout, count: int) -> Array:
    """(count, 6) from far inside the attainable set to far outside."""
    generator = np.random.default_rng(5)
    size = generator.choice([0.02, 0.3, 1.0, 3.0], size=count)[:, None]
    return generator.normal(size=(count, 6)) * size * np.mean(limits(layout), axis=0)


@pytest.mark.parametrize("name", ALL)
def test_bounded_least_squares_is_that_of_scipy(name: str, full: bool) -> None:
    """To 1e-8 of the largest thrust. Kills: a weight left out, half the iterations, no corrector, no last step, ε left out."""
    if name == "pinwheel-12" and not full:
        pytest.skip("two layouts by default; the third with --long")
    layout, count = ALL[name], 400 if full else 120
    given = wrenches(layout, count)
    allocate = bounded_least_squares(layout)
    shares = jax.jit(jax.vmap(lambda *w: jnp.stack(allocate.at(Channels.of(w)).parts())))(*given.T)
    most, weight = np.array(layout.most), 1.0 / np.mean(limits(layout), axis=0)
    stacked = np.vstack([weight[:, None] * matrix(layout) * most, np.sqrt(EPSILON) * np.eye(len(most))])
    inside = 0
    for own, asked in zip(np.asarray(shares), given, strict=True):
        right = np.append(weight * asked, np.zeros(len(most)))
        exact = lsq_linear(stacked, right, bounds=(0.0, 1.0), method="bvls", tol=1e-15).x
        np.testing.assert_allclose(own, exact, atol=1e-8, rtol=0.0)
        inside += bool(np.abs(weight * (matrix(layout) @ (own * most) - asked)).max() < 1e-3)
    assert 0.2 * count < inside < 0.8 * count


@pytest.mark.parametrize("centre", [0.5, 0.2])
@pytest.mark.parametrize("name", ALL)
def test_the_pseudo_inverse_is_exact_until_it_is_clipped(name: str, centre: float) -> None:
    """Kills: a centre that is not taken out of the wrench, no clip, B⁺ of a matrix without its scale."""
    layout = ALL[name]
    b, most = matrix(layout), np.array(layout.most)
    scale = np.diag(1.0 / np.mean(limits(layout), axis=0))
    first = centre * most
    inverse = np.diag(most) @ np.linalg.pinv(scale @ b @ np.diag(most)) @ scale
    free = 0
    for asked in wrenches(layout, 60) * 0.5:
        thrusts = pseudo_inverse(layout, centre).at(Channels.of(tuple(asked))) * Thrusts(layout.most)
        wanted = first + inverse @ (asked - b @ first)
        np.testing.assert_allclose(thrusts.parts(), np.clip(wanted, 0.0, most), atol=1e-12)
        given = np.array(wrench(layout)(thrusts).parts())
        np.testing.assert_allclose(given, b @ np.array(thrusts.parts()), atol=1e-12)
        if (np.clip(wanted, 0.0, most) == wanted).all():
            np.testing.assert_allclose(given, asked, atol=1e-12)
            free += 1
    assert free


FLIGHT = (
    "actuators={use: thrusters, layout: pinwheel-12, size_m: 0.7, max_N: 2.0, spread: {uniform: [0.9, 1.1]}, "
    "allocation: pseudo-inverse}",
    "controller={use: pd-plus}",
)
"""`--set` values."""


def loaded(*faults: str, **more: str) -> tuple[Problem, Draws, Drawn]:
    """Four samples with these faults, and what flies of them."""
    problem = load(CAMPAIGN, [*FLIGHT, f"faults=[{', '.join(faults)}]", *(f"{key}={value}" for key, value in more.items())])
    return problem, *Draws.of(problem, np.arange(4, dtype=np.int64))


def begun(problem: Problem, drawn: Drawn, t: float = 1.0) -> Step:
    """Everything where a step begins, with every sample in its lane."""

    def first(numbers: Drawn) -> Step:
        y, held = closed_loop.start(problem.loop, numbers)
        return closed_loop.evaluate(problem.loop, numbers, t, y, held, Tick(20, t, 0.05))[1]

    return jax.vmap(first)(drawn)


@pytest.mark.parametrize("lost", ["t1", "t8", "t12"])
def test_a_lost_thruster_takes_exactly_its_column(lost: str) -> None:
    """Kills: a fault on the wrench, on a thruster beside it, an allocation that knows of it, a nominal B without its torque."""
    whole = begun(*loaded()[::2])
    problem, _, drawn = loaded(f"{{use: float, onset_s: 0, channels: [{lost}]}}")
    failed = begun(problem, drawn)
    assert isinstance(whole.thrusts, Thrusts)
    assert isinstance(failed.thrusts, Thrusts)
    index = int(lost[1:]) - 1
    column = matrix(ALL["pinwheel-12"])[:, index]
    before, after = np.array(whole.thrusts.parts()), np.array(failed.thrusts.parts())
    assert before[index].max() > 0.1
    np.testing.assert_array_equal(after[index], 0.0)
    np.testing.assert_array_equal(np.delete(after, index, axis=0), np.delete(before, index, axis=0))
    taken = np.array(whole.applied.parts()) - np.array(failed.applied.parts())
    np.testing.assert_allclose(taken, np.outer(column, before[index]), atol=1e-14)
    np.testing.assert_allclose(whole.applied.parts(), matrix(ALL["pinwheel-12"]) @ before, atol=1e-14)


def test_faults_come_behind_the_true_limits_and_no_thruster_pulls() -> None:
    """Kills: the nominal limit of a fault, a thrust below zero or above the most, the spread in the allocation."""
    problem, draws, drawn = loaded(
        "{use: stuck, onset_s: 0, share: 0.5, channels: [t3]}",
        "{use: bias, name: leak, onset_s: 0, share: 1, channels: [t4]}",
        "{use: bias, onset_s: 0, share: -1, channels: [t5]}",
    )
    thrusts = begun(problem, drawn).thrusts
    assert isinstance(thrusts, Thrusts)
    np.testing.assert_allclose(thrusts.parts()[2], 0.5 * 2.0 * draws.values["actuators.spread.t3"], rtol=1e-15)
    np.testing.assert_allclose(thrusts.parts()[3], 2.0 * draws.values["actuators.spread.t4"], rtol=1e-15)
    np.testing.assert_array_equal(thrusts.parts()[4], 0.0)
    for index, thrust in enumerate(thrusts.parts()):
        assert (thrust <= 2.0 * draws.values[f"actuators.spread.t{index + 1}"]).all()
    more = drawn._replace(plant=drawn.plant._replace(thrust=drawn.plant.thrust * 1.05))
    again = begun(problem, more).thrusts
    assert isinstance(again, Thrusts)
    np.testing.assert_allclose(np.array(again.parts()), 1.05 * np.array(thrusts.parts()), rtol=1e-14)


def test_the_controller_knows_the_nominal_limits() -> None:
    """Kills: drawn limits in what is seen, limits of the wrench form."""
    _, _, drawn = loaded()
    for known, exact in ((drawn.upper, [4.0] * 3 + [1.4] * 3), (drawn.plant.upper, [4.0] * 3 + [1.4] * 3)):
        np.testing.assert_allclose(np.array(known.parts()), np.outer(exact, np.ones(4)), rtol=1e-12)


def test_thrusts_follow_the_command_within_a_step_and_a_fault_begins_at_its_instant() -> None:
    """Kills: a hold, the command of the step's beginning, a fault that waits for the next step."""
    problem, _, drawn = loaded("{use: float, onset_s: 1.02, channels: [t2]}")
    one = jax.tree.map(lambda x: x[1], drawn)
    y, held = closed_loop.start(problem.loop, one)
    _, first, held = closed_loop.evaluate(problem.loop, one, 1.0, y, held, Tick(20, 1.0, 0.05))
    y = y._replace(motion=y.motion._replace(nu=y.motion.nu * 0.9))
    _, later, _ = closed_loop.evaluate(problem.loop, one, 1.01, y, held)
    _, failed, _ = closed_loop.evaluate(problem.loop, one, 1.025, y, held)
    assert isinstance(later.thrusts, Thrusts)
    assert isinstance(failed.thrusts, Thrusts)
    assert first.thrusts != later.thrusts
    assert failed.thrusts.parts()[1] == 0.0 < later.thrusts.parts()[1]


@pytest.mark.parametrize("name", ALL)
def test_the_solution_of_a_step_is_followed_to_first_order(name: str, full: bool) -> None:
    """Exact while the same thrusters move; otherwise nearer than a hold. Kills: a hold, a sign, the weights, thrusters at an end
    that move."""
    if name != "crooked" and not full:
        pytest.skip("the layout without symmetry by default; the others with --long")
    layout = ALL[name]
    allocation = bounded_least_squares(layout)
    given = wrenches(layout, 400)
    moves = np.random.default_rng(6).normal(size=given.shape) * 1e-3 * np.mean(limits(layout), axis=0)

    def both(w: tuple[jax.Array, ...], v: tuple[jax.Array, ...]) -> tuple[Thrusts, Thrusts, Thrusts]:
        kept, anew = allocation.solve(Channels.of(w)), allocation.solve(Channels.of(v))
        return kept.x, allocation.follow(Channels.of(v), kept), anew.x

    held, followed, exact = (np.array(x.parts()).T for x in jax.jit(jax.vmap(both))(tuple(given.T), tuple((given + moves).T)))
    same = ((held > 0) & (held < 1) == ((exact > 0) & (exact < 1))).all(axis=1) & ((held == 0) == (exact == 0)).all(axis=1)
    assert same.sum() > 100
    np.testing.assert_allclose(followed[same], exact[same], atol=1e-8)
    columns = matrix(layout) * np.array(layout.most) / np.mean(limits(layout), axis=0)[:, None]
    wrong, hold = (np.linalg.norm((x - exact) @ columns.T, axis=1) for x in (followed, held))
    assert wrong.max() < 2 * hold.max()
    assert wrong.mean() < 0.1 * hold.mean()


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_rounding_at_a_bound_decides_nothing(dtype: type[np.floating[Any]]) -> None:
    """For a wrench of zero all thrusters are at their bound, none is pressed against it, and the last digit may say either.
    Kills: comparing a share with 0 and 1 exactly, so that two compilers fly different first steps."""
    allocation = bounded_least_squares(ALL["cube-24"])
    zero, small = (Channels.of((dtype(value),) * 6) for value in (0.0, 0.01))
    solved = allocation.solve(zero)
    assert max(float(share) for share in solved.x.parts()) < 1e-12
    moved = [
        allocation.follow(small, solved._replace(x=Thrusts((share,) * 24)))
        for share in (dtype(1e-30), dtype(0.0), dtype(1.0), np.nextafter(dtype(1.0), dtype(0.0)))
    ]
    for near, at in (moved[:2], moved[2:]):
        np.testing.assert_allclose(np.array(near.parts()), np.array(at.parts()), rtol=0.0, atol=1e-6)


def test_faults_are_drawn_for_each_thruster_and_may_be_scheduled() -> None:
    """Kills: six draws, names of channels, one onset for all, a group of channels."""
    fault = "use: effectiveness, onset_s: {uniform: [2, 10]}, remaining: {uniform: [0, 1]}, channels: [t1, t7, t12]"
    problem, draws, drawn = loaded(f"{{{fault}, schedule: {{count: 1, groups: [[t1, t12]]}}}}")
    able = {"t1", "t7", "t12"}
    for name in ("onset_s", "remaining"):
        assert {one.rpartition(".")[2] for one in draws.values if f"effectiveness.{name}." in one} == able
    onset = np.array(drawn.faults[0].onset_s.parts())
    assert onset.shape == (12, 4)
    never = [index for index in range(12) if f"t{index + 1}" not in able]
    assert (onset[never] > 1e29).all()
    starts = np.isfinite(onset) & (onset < 1e29)
    np.testing.assert_array_equal(starts[0], starts[11])
    np.testing.assert_array_equal(draws.values["faults.effectiveness.schedule.failing"], starts.sum(axis=0))
    (_, _, trace, *_), columns = trace_tables([begun(problem, drawn)], {}, measured=False)
    assert [name for name in trace if str(name).startswith("thrust_")] == [f"thrust_t{index + 1}_N" for index in range(12)]
    assert columns["thrust_t12_N"].unit == "N"
