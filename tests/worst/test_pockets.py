"""Planted failure pockets of probability 1e-6 are found within 20,000 flights, and the search keeps its word otherwise.

Every function is turned at random for each seed, so that no axis is favoured, and has its probability from an oracle: the normal
law of a linear margin, the noncentral chi-square law of a ball. Factors that are positive everywhere leave the failures as
they are, and so the probability.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.random import Generator
from numpy.typing import NDArray
from scipy import optimize, special, stats

from rvjax.search.failure_search import Domain, Searched, search

Values = NDArray[np.float64]
Margin = Callable[[Values], Values]

RARE, FLIGHTS, BATCH, SEEDS, SOME, ENOUGH = 1e-6, 20_000, 200, 100, 25, 0.95
BETA = float(stats.norm.isf(RARE))


def directions(rng: Generator, dimension: int, count: int = 1) -> Values:
    """(d, count) orthonormal, uniformly turned."""
    return np.linalg.qr(rng.standard_normal((dimension, count)))[0]


def ball_radius(dimension: int, centre: float) -> float:
    """r with P(|z - c| < r) = 1e-6: |z - c|² is noncentral chi-square with noncentrality |c|²."""
    return optimize.brentq(lambda r: stats.ncx2.cdf(r * r, dimension, centre**2) - RARE, 1e-3, centre + 5)


def half_space(rng: Generator, dimension: int) -> Margin:
    w = directions(rng, dimension)[:, 0]
    return lambda z: BETA - z @ w


def ball(rng: Generator, dimension: int, centre: float) -> Margin:
    radius, c = ball_radius(dimension, centre), centre * directions(rng, dimension)[:, 0]
    return lambda z: np.linalg.norm(z - c, axis=1) - radius


def decoyed(rng: Generator, dimension: int, centre: float) -> Margin:
    """The ball, and a cone of gentle slope whose bottom, nearer to the origin, stays positive."""
    pocket, q = ball(rng, dimension, centre), 1.5 * directions(rng, dimension)[:, 0]
    return lambda z: np.minimum(pocket(z), 0.3 + 0.25 * np.linalg.norm(z - q, axis=1))


def union(rng: Generator, dimension: int) -> Margin:
    """Orthogonal half-spaces: P = 1 - (1 - Φ(-4.8)) (1 - Φ(-b)), solved for b."""
    first = 4.8
    second = float(stats.norm.isf(1 - (1 - RARE) / stats.norm.cdf(first)))
    w = directions(rng, dimension, 2)
    return lambda z: np.minimum(first - z @ w[:, 0], second - z @ w[:, 1])


def rippled(rng: Generator, dimension: int) -> Margin:
    """The ball with its decoy, times 1 + ½ of a mean of sines in all directions: local minima everywhere."""
    smooth, w = decoyed(rng, dimension, 4.5), directions(rng, dimension, dimension)
    return lambda z: smooth(z) * (1 + 0.5 * np.mean(np.sin(5 * z @ w), axis=1))


def noisy(rng: Generator, dimension: int) -> Margin:
    """A half-space times a factor between ½ and 1½ that nothing but the very same draw repeats."""
    smooth = half_space(rng, dimension)
    return lambda z: smooth(z) * (1 + 0.5 * np.sin(1e5 * np.sum(z, axis=1)))


def capped(margin: Margin, cap: float) -> Margin:
    return lambda z: np.minimum(margin(z), cap)


FUNCTIONS: dict[str, tuple[int, float | None, Callable[[Generator], Margin]]] = {
    "half-space": (20, None, lambda rng: half_space(rng, 20)),
    "half-space within 5.5 sigma": (20, 5.5, lambda rng: half_space(rng, 20)),
    "ball and decoy, 4": (4, None, lambda rng: decoyed(rng, 4, 4.0)),
    "ball and decoy, 6": (6, None, lambda rng: decoyed(rng, 6, 4.5)),
    "ball and decoy, 8": (8, None, lambda rng: decoyed(rng, 8, 4.5)),
    "ball and decoy, 8, within 6 sigma": (8, 6.0, lambda rng: decoyed(rng, 8, 4.5)),
    "flat ball": (6, None, lambda rng: capped(ball(rng, 6, 4.5), 1.5)),
    "flat half-space within 5 sigma": (10, 5.0, lambda rng: capped(half_space(rng, 10), 1.0)),
    "two half-spaces within 6 sigma": (10, 6.0, lambda rng: union(rng, 10)),
    "rippled ball and decoy": (6, None, lambda rng: rippled(rng, 6)),
    "noisy half-space within 5.5 sigma": (20, 5.5, lambda rng: noisy(rng, 20)),
}
SHORT = ("half-space", "ball and decoy, 4")


def hunt(name: str, seed: int, **options: bool) -> Searched:
    dimension, radius, make = FUNCTIONS[name]
    return search(
        make(np.random.default_rng(10_000 + seed)), dimension, seed, flights=FLIGHTS, batch=BATCH, radius=radius, **options
    )


@pytest.mark.parametrize("name", FUNCTIONS)
def test_pockets_of_one_in_a_million_are_found(name: str, full: bool, figure: Callable[[str], None]) -> None:
    """Kills, with --long (drafts of the search): starts at the best of many neighbours alone; no end of repeats."""
    if not full and name not in SHORT:
        pytest.skip("--long")
    seeds = SEEDS if full else SOME
    found = [hunt(name, seed) for seed in range(seeds)]
    used = [one.flights_used for one in found if one.margin < 0]
    figure(f"pockets, {name}: found with {len(used)} of {seeds} seeds, median {np.median(used):.0f} flights")
    assert len(used) >= ENOUGH * seeds


def test_probabilities_of_the_planted_pockets_by_counting_in_one_direction() -> None:
    """Kills: the radius of the ball taken for its square, the noncentrality for its root: P by a quadrature in cylinders.

    P = ∫ φ(x) P(χ²(d - 1) < r² - (x - c)²) dx.
    """
    for dimension, centre in ((4, 4.0), (6, 4.5), (8, 4.5)):
        r = ball_radius(dimension, centre)
        x = np.linspace(centre - r, centre + r, 20_001)
        density = stats.norm.pdf(x) * stats.chi2.cdf(r * r - (x - centre) ** 2, dimension - 1)
        assert np.trapezoid(density, x) == pytest.approx(RARE, rel=1e-6)
    assert special.ndtr(-BETA) == pytest.approx(RARE)


def test_a_failure_is_made_more_probable_with_the_flights_that_remain() -> None:
    """Kills: failures ordered by margin where they are to be refined."""
    found = hunt("half-space", 3, until_failure=False)
    nearest = found.failures[np.argmin(np.linalg.norm(found.failures, axis=1))]
    assert found.flights_used == FLIGHTS
    assert BETA <= np.linalg.norm(nearest) < 1.06 * BETA


def test_the_smallest_margin_of_a_ball_is_on_its_sphere() -> None:
    """Kills: refine ignored; a radius ignored. β - k is the smallest margin within k sigma."""
    found = hunt("half-space within 5.5 sigma", 3, until_failure=False, refine=False)
    assert found.margin == pytest.approx(BETA - 5.5, abs=0.08)
    assert found.margin >= BETA - 5.5


def test_same_seed_same_flights_and_another_seed_others() -> None:
    """Kills: a generator without the seed, in the screening or in the searches."""

    def flown(seed: int) -> Values:
        rows: list[Values] = []

        def margin(z: Values) -> Values:
            rows.append(z.copy())
            return np.sum(z**2, axis=1) + 1

        search(margin, 3, seed, flights=1000, batch=64)
        return np.concatenate(rows)

    assert np.array_equal(flown(5), flown(5))
    assert not np.any(np.all(np.equal(flown(5), flown(6)), axis=1))


@pytest.mark.parametrize(("flights", "batch"), [(1, 1), (7, 20), (100, 7), (1000, 300), (2000, 2000), (500, 1)])
def test_batches_are_whole_and_flights_never_exceeded(flights: int, batch: int) -> None:
    """Kills: a last batch that is not cut; a batch for each search; a history of each batch alone."""
    sizes: list[int] = []

    def margin(z: Values) -> Values:
        assert z.shape[1] == 2
        sizes.append(len(z))
        return np.sum(z**2, axis=1) + 1

    found = search(margin, 2, 0, flights=flights, batch=batch)
    assert sum(sizes) == flights == found.flights_used
    assert all(size == batch for size in sizes[:-1])
    assert sizes[-1] == (flights % batch or min(batch, flights))
    assert len(found.history) == len(sizes)
    assert np.all(np.diff(found.history) <= 0)
    assert found.history[-1] == found.margin
    assert found.failures.shape == (0, 2)


def test_a_lost_flight_is_a_failure() -> None:
    """Kills: NaN left as it is, which no comparison takes for less than 0."""
    found = search(lambda z: np.where(z[:, 0] > 2, np.nan, 1.0), 3, 0, flights=20_000, batch=50)
    assert found.margin == -np.inf
    assert found.z[0] > 2
    assert len(found.failures)
    assert np.all(found.failures[:, 0] > 2)


@pytest.mark.parametrize(("radius", "most_sigma"), [(None, 6.0), (None, 2.0), (3.0, 6.0), (7.0, 2.5)])
def test_points_stay_in_the_domain(radius: float | None, most_sigma: float) -> None:
    """Kills: screening or generations that are not brought back; the box ignored where there is a ball."""
    w = np.ones(12) / np.sqrt(12)
    rows: list[Values] = []

    def margin(z: Values) -> Values:
        rows.append(z.copy())
        return 100 - z @ w

    found = search(margin, 12, 1, flights=6000, batch=100, radius=radius, most_sigma=most_sigma)
    z = np.concatenate(rows)
    assert np.max(np.abs(z)) <= most_sigma
    uniform = special.ndtr(z)
    assert np.all((uniform > 0) & (uniform < 1))
    if radius is not None:
        assert np.max(np.linalg.norm(z, axis=1)) <= radius
    farthest = np.sqrt(12) * most_sigma if radius is None else min(radius, np.sqrt(12) * most_sigma)
    assert 100 - found.margin > 0.92 * farthest


def test_points_outside_are_reflected_and_drawn_to_the_ball() -> None:
    """Kills: clipping in place of reflecting, which heaps points on the sides; a point inside that is moved."""
    z = np.array([[0.5, -1.0, 2.5, -2.25, 5.0]])
    assert np.allclose(Domain(2.0).inside(z), [[0.5, -1.0, 1.5, -1.75, -1.0]])
    assert np.allclose(Domain(6.0, 2.0).inside(np.array([[3.0, 4.0], [0.3, 0.4]])), [[1.2, 1.6], [0.3, 0.4]])


@pytest.mark.parametrize("wrong", [{"dimension": 0}, {"flights": 0}, {"batch": 0}, {"radius": 0.0}, {"most_sigma": 9.0}])
def test_nonsense_is_refused(wrong: dict[str, float]) -> None:
    """Kills: a check that is left out."""
    given = {"dimension": 2, "seed": 0, "flights": 10, "batch": 5, **wrong}
    with pytest.raises(ValueError, match=next(iter(wrong))):
        search(lambda z: z[:, 0], **given)  # type: ignore[arg-type]
