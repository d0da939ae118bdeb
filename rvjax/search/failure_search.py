"""The smallest margin over the draws of a campaign: where a requirement fails, however improbable that is.

A draw is a point z of standard normal space, z_i = Φ⁻¹(u_i), where u_i is the uniform number that a law turns into the draw.
The more probable a draw is, the nearer z is to the origin. A campaign that fails with probability 10⁻⁶ fails in pockets of this
space; random draws meet a pocket after 10⁶ flights, whereas a margin that slopes towards a pocket leads there after thousands:

    smallest margin         min g(z)   subject to  |z_i| <= s   and, if there is a radius,  |z| <= k
    most probable failure   min |z|    subject to  g(z) < 0, as well                                     (Hasofer & Lind)
    order of points         failures before all others; failures by |z|, the others by g(z)
    linear margin           g(z) = β - w·z, |w| = 1:  the most probable failure is β w, and P(failure) = Φ(-β)

Symbols

    z      point of standard normal space, in standard deviations    g    margin; < 0, or no number at all: a failure
    d      dimension, the number of draws of a sample                s    most_sigma, half of the side of the box
    k      radius of the ball, in standard deviations                λ    population: points in a generation of a search

Steps: (1) Screening. Three tenths of the flights go to scrambled Sobol points made normal and stretched by 1 ... 2.5: pockets lie
farther out than most draws. (2) Starts. A screened point is the better a start, the more of its nearest neighbours are no worse
than itself before the first that is (the nearest-better idea): a basin is started from early even where another basin has
smaller margins everywhere. (3) Searches. CMA-ES runs from several starts at once; a batch takes its flights from as many
generations as fill it. A search ends where its points have contracted, where nothing improves, and where it repeats another
search: the mean of a better search is inside its cloud, or within a standard deviation. (4) Restarts come in
two kinds, as in BIPOP: small populations from the next screened point, and from time to time a random start, whose population
doubles each time.

CMA-ES gets only the order of points, so saturated and rippled margins work as well as smooth ones. After a failure the same
searches continue with the most probable failure. A search without a failure does not prove that there is none.

Sources: N. Hansen, The CMA evolution strategy: a tutorial, arXiv:1604.00772 (2016); A. Auger & N. Hansen, CEC (2005) (growing
restarts); N. Hansen, GECCO (2009) (BIPOP); M. Preuss, GECCO (2010) (nearest-better clustering); A. M. Hasofer & N. C. Lind,
J. Eng. Mech. Div. ASCE 100 (1974) 111 (most probable point).
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from cmaes import CMA
from numpy.typing import NDArray
from scipy import spatial, special, stats  # pyright: ignore[reportMissingTypeStubs]

Values = NDArray[np.float64]
Margin = Callable[[Values], Values]

FARTHEST = 8.0
"""Largest most_sigma: beyond it Φ(z) is 1 in double precision, and no uniform number of a law."""
SCREENED, MOST_SCREENED, WIDEST = 0.3, 8192, 2.5
"""Share of the flights for screening; their largest number; largest stretch of a screened point."""
NEIGHBOURS, ANYWHERE = 16, 6
"""Nearest neighbours that a start is compared with; every ANYWHERE-th start is a random point."""
SEARCHES = 16  # about this number of populations fills a batch
STEP, SAME, FINE = 0.5, 1.0, 0.03
"""In σ: first step from a screened point; means nearer than this are the same basin; a search with less scatter is over."""


@dataclass(frozen=True)
class Searched:
    """Result of a search. Points are in standard normal space.

    z: (d,) the point of the smallest margin. margin: that margin, -∞ where it was no number. flights_used: rows flown.
    failures: (m, d) all points that failed, as they were flown. history: (batches,) the smallest margin up to each batch.
    """

    z: Values
    margin: float
    flights_used: int
    failures: Values
    history: Values


def search(
    margin: Margin,
    dimension: int,
    seed: int,
    *,
    flights: int,
    batch: int,
    radius: float | None = None,
    most_sigma: float = 6.0,
    until_failure: bool = True,
    refine: bool = True,
) -> Searched:
    """min g(z) over the box |z_i| <= most_sigma, inside the ball |z| <= radius if there is one, with up to `flights` flights.

    margin: (n, d) points to (n,) margins, called with `batch` rows, and fewer only in the last call. until_failure: stop after
    the first batch with a failure. Else use all flights; after a failure for the most probable failure (refine) or still for the
    smallest margin. A function of the seed.
    ValueError unless dimension, flights and batch are >= 1, 0 < most_sigma <= 8 and radius > 0.
    """
    if min(dimension, flights, batch) < 1:
        raise ValueError(f"dimension, flights and batch must be at least 1; found {dimension}, {flights} and {batch}")
    if not 0 < most_sigma <= FARTHEST or (radius is not None and not radius > 0):
        raise ValueError(f"radius and most_sigma must be above 0, most_sigma at most {FARTHEST:g}; found {radius}, {most_sigma}")
    rng = np.random.default_rng(seed)
    domain = Domain(most_sigma, radius)
    log = _Log(margin, flights, batch, until_failure, refine)
    _screen(log, domain, dimension, rng)
    _evolve(log, _starts(log, domain, dimension, rng))
    return log.result()


@dataclass(frozen=True)
class Domain:
    """{z: |z_i| <= most_sigma, |z| <= radius}, in standard deviations."""

    most_sigma: float
    radius: float | None = None

    def inside(self, z: Values) -> Values:
        """(n, d) the points, reflected at the sides of the box and then drawn radially to the ball: both leave what is inside."""
        side = self.most_sigma
        z = np.where(np.abs(z) <= side, z, side - np.abs((z + side) % (4 * side) - 2 * side))
        if self.radius is None:
            return z
        length = _length(z)[:, None]
        return np.where(length <= self.radius, z, z * (self.radius * (1 - 1e-12) / np.maximum(length, self.radius)))


class _Log:
    """All flights so far and the number that is left."""

    def __init__(self, margin: Margin, flights: int, batch: int, until_failure: bool, refine: bool):
        self.margin, self.flights, self.batch = margin, flights, batch
        self.until_failure, self.refine = until_failure, refine
        self.used, self.failed = 0, False
        self.points: list[Values] = []
        self.margins: list[Values] = []

    @property
    def rows(self) -> int:
        """Rows of the next batch; 0 at the end."""
        return 0 if self.until_failure and self.failed else min(self.batch, self.flights - self.used)

    def note(self, z: Values, margins: Values) -> Values:
        """(n,) the margins of a batch that was flown, -∞ in place of no number."""
        values = np.asarray(margins, dtype=np.float64)
        values = np.where(np.isnan(values), -np.inf, values)
        self.used += len(z)
        self.failed = self.failed or bool(np.any(values < 0))
        self.points.append(z)
        self.margins.append(values)
        return values

    def order(self, z: Values, margins: Values) -> NDArray[np.int64]:
        """(n,) the rows from best to worst: failures before others, by |z| where they are refined, all else by margin."""
        value = np.where(margins < 0, _length(z), margins) if self.refine else margins
        return np.lexsort((value, margins >= 0))

    def flown(self) -> tuple[Values, Values]:
        """(n, d) points and (n,) margins so far."""
        return np.concatenate(self.points), np.concatenate(self.margins)

    def result(self) -> Searched:
        """The result of all batches."""
        z, margins = self.flown()
        least = int(np.argmin(margins))
        history = np.minimum.accumulate([np.min(values) for values in self.margins])
        return Searched(z[least], float(margins[least]), self.used, z[margins < 0], history)


def _length(z: Values) -> Values:
    """(n,) |z|. z: (n, d)."""
    return np.linalg.norm(z, axis=-1)


def _screen(log: _Log, domain: Domain, dimension: int, rng: np.random.Generator) -> None:
    """Flies z = a Φ⁻¹(u), 1 <= a <= 2.5, with (u, a) a scrambled Sobol sequence."""
    wanted = min(MOST_SCREENED, int(SCREENED * log.flights))
    count = min(log.flights, max(1, wanted // log.batch) * log.batch)
    sobol = stats.qmc.Sobol(dimension + 1, rng=rng).random_base2((count - 1).bit_length())[:count]
    normal = special.ndtri(np.clip(sobol[:, 1:], 1e-15, 1 - 1e-15))
    z = domain.inside((1 + (WIDEST - 1) * sobol[:, :1]) * normal)
    for first in range(0, count, log.batch):
        if log.rows:
            log.note(part := z[first : first + log.batch], log.margin(part))


class _Evolution:
    """A CMA-ES search: asks for a whole generation and gets its answers point by point."""

    def __init__(self, log: _Log, domain: Domain, start: Values, step: float, population: int, seed: int):
        self.cma = CMA(start, step, population_size=population, seed=seed)
        self.log, self.domain = log, domain
        self.patience = 10 + 30 * len(start) // population
        self.idle_generations = 0
        self.best = (2, np.inf)
        self.over = False

    def ask(self) -> None:
        """z: (λ, d) the next generation, inside of the domain."""
        self.z = self.domain.inside(np.array([self.cma.ask() for _ in range(self.cma.population_size)]))
        self.margins = np.full(len(self.z), np.inf)
        self.missing = len(self.z)

    def answer(self, row: int, margin: float) -> bool:
        """Whether this was the last point of the generation."""
        self.margins[row] = margin
        self.missing -= 1
        if self.missing:
            return False
        ranked = self.log.order(self.z, self.margins)
        self.cma.tell([(self.z[row], float(rank)) for rank, row in enumerate(ranked)])
        first, margin = self.z[ranked[0]], float(self.margins[ranked[0]])
        refined = margin < 0 and self.log.refine
        best = (int(margin >= 0), float(np.linalg.norm(first)) if refined else margin)
        self.idle_generations = 0 if best < self.best else self.idle_generations + 1
        self.best = min(best, self.best)
        variance = np.var(self.z, axis=0)
        self.size = max(SAME, min(STEP * len(first) ** 0.5, float(np.sqrt(np.sum(variance)))))
        flat = bool(np.all(self.margins == margin)) and not refined
        self.over = flat or self.idle_generations > self.patience or float(np.max(variance)) < FINE**2
        return True

    def repeats(self, other: _Evolution) -> bool:
        """Whether the other search is no worse and its mean is within the cloud of this search, at most a first cloud wide."""
        return other.best <= self.best and float(np.linalg.norm(self.cma.mean - other.cma.mean)) < self.size


def _evolve(log: _Log, starts: Iterator[_Evolution]) -> None:
    """Flies batches filled with generations of searches, in turn, until the end; starts new searches where points are missing."""
    waiting: deque[tuple[_Evolution, int]] = deque()
    ready: deque[_Evolution] = deque()
    basins: list[_Evolution] = []
    while rows := log.rows:
        while len(waiting) < rows:
            evolution = ready.popleft() if ready else next(starts)
            evolution.ask()
            waiting.extend((evolution, row) for row in range(len(evolution.z)))
        flying = [waiting.popleft() for _ in range(rows)]
        z = np.array([evolution.z[row] for evolution, row in flying])
        margins = log.note(z, log.margin(z))
        for (evolution, row), margin in zip(flying, margins, strict=True):
            if not evolution.answer(row, float(margin)):
                continue
            basins = [other for other in basins if other is not evolution]
            if not any(evolution.repeats(other) for other in basins):
                basins.append(evolution)
                ready.extend([evolution] * (not evolution.over))


def _starts(log: _Log, domain: Domain, dimension: int, rng: np.random.Generator) -> Iterator[_Evolution]:
    """Searches without end: from screened points in turn, and from anywhere with populations that double."""
    z, margins = log.flown()
    screened = iter(_alone(z, log.order(z, margins), margins))
    small = max(4 + int(3 * np.log(dimension)), log.batch // SEARCHES)
    large, most = small, max(small, log.batch, log.flights // 40)
    for turn in itertools.count(1):
        row = next(screened, None) if turn % ANYWHERE else None
        seed = int(rng.integers(2**31))
        if row is not None:
            yield _Evolution(log, domain, z[row], STEP, small, seed)
        else:
            large = large if turn % ANYWHERE else min(2 * large, most)
            start = domain.inside(rng.uniform(0, WIDEST) * rng.standard_normal((1, dimension)))[0]
            step = float(rng.uniform(STEP, 4 * STEP))
            yield _Evolution(log, domain, start, step, small if turn % ANYWHERE else large, seed)


def _alone(z: Values, order: NDArray[np.int64], margins: Values) -> NDArray[np.int64]:
    """The rows with a smaller margin than their nearest neighbour, those first that the most neighbours miss. z: (n, d)."""
    if len(z) == 1:
        return order
    count = min(NEIGHBOURS + 1, len(z))
    near = np.asarray(spatial.KDTree(z).query(z, count)[1], dtype=np.int64)
    worse = margins[near[:, 1:]] > margins[:, None]
    reach = np.where(np.all(worse, axis=1), count, np.argmin(worse, axis=1))
    ranked = order[np.argsort(-reach[order], kind="stable")]
    return ranked[reach[ranked] > 0]
