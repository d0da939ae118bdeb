"""Thrusters: what layouts can give, against the facets of the zonotope; allocation, against SciPy's bounded least squares."""

from __future__ import annotations

import itertools
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from rvjax.algebra import Channels
from rvjax.allocation import EPSILON, bounded_least_squares, pseudo_inverse, wrench
from rvjax.columns import CHANNELS
from rvjax.spec.layout import LAYOUTS, Layout, cube, limits, margins, pinwheel, rank

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
def test_bounded_least_squares_is_that_of_scipy(name: str) -> None:
    """To 1e-8 of the largest thrust. Kills: a weight left out, half the iterations, no corrector, no last step, ε left out."""
    layout, count = ALL[name], 400
    given = wrenches(layout, count)
    allocate = bounded_least_squares(layout)
    thrusts = jax.jit(jax.vmap(lambda *w: jnp.stack(allocate(Channels.of(w)).parts())))(*given.T)
    most, weight = np.array(layout.most), 1.0 / np.mean(limits(layout), axis=0)
    stacked = np.vstack([weight[:, None] * matrix(layout) * most, np.sqrt(EPSILON) * np.eye(len(most))])
    inside = 0
    for own, asked in zip(np.asarray(thrusts), given, strict=True):
        right = np.append(weight * asked, np.zeros(len(most)))
        exact = lsq_linear(stacked, right, bounds=(0.0, 1.0), method="bvls", tol=1e-15).x
        np.testing.assert_allclose(own / most, exact, atol=1e-8, rtol=0.0)
        inside += bool(np.abs(weight * (matrix(layout) @ own - asked)).max() < 1e-3)
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
        thrusts = pseudo_inverse(layout, centre)(Channels.of(tuple(asked)))
        wanted = first + inverse @ (asked - b @ first)
        np.testing.assert_allclose(thrusts.parts(), np.clip(wanted, 0.0, most), atol=1e-12)
        given = np.array(wrench(layout)(thrusts).parts())
        np.testing.assert_allclose(given, b @ np.array(thrusts.parts()), atol=1e-12)
        if (np.clip(wanted, 0.0, most) == wanted).all():
            np.testing.assert_allclose(given, asked, atol=1e-12)
            free += 1
    assert free
