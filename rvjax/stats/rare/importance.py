"""Importance sampling over standard normal space: the law is learned once from failing points, then frozen.

    S  = coordinates whose mean or variance among failing points differs from N(0, 1)      (z-tests, Bonferroni)
    q  = a₀ φ + (1 − a₀) Σ_k a_k N(m_k, s_k² I) in S, N(0, 1) elsewhere;     a₀ = 0.1, K ≤ 12 by BIC, s_k² inflated by 1.15
    p̂ = mean of 1{g ≤ 0} φ/q,     φ/q ≤ 1/a₀ = 10

Without S the law would be fitted in hundreds of coordinates that do not matter; its weights then collapse, and the interval is
wrong without looking so. The estimate is unbiased for every frozen q. It is refused where its weights say that it cannot be
trusted:

    effective sample size (Σ w)²/Σ w² of failing weights < 100      a weight > 5 % of their sum      Pareto k̂ > 0.7
    its interval and that of splitting, each at 99.5 %, have no number in common

Sources: A. B. Owen, "Monte Carlo theory, methods and examples", ch. 9 (defensive mixtures); `gaussian_mixture`, `tail_index`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]
from numpy.typing import NDArray

from rvjax.stats.binomial import Estimate
from rvjax.stats.rare.gaussian_mixture import Mixture, fit
from rvjax.stats.rare.points import KEYS, Points, Values, failed
from rvjax.stats.rare.replicates import student_interval
from rvjax.stats.rare.tail_index import tail_index

DEFENSIVE, MOST_PARTS, INFLATION = 0.1, 12, 1.15
SELECTION = 0.01
"""Probability that a coordinate without influence is selected, over all coordinates together."""
LEAST_EFFECTIVE, LARGEST_SHARE, HEAVIEST, AGREEMENT = 100.0, 0.05, 0.7, 0.99
LEARNED = 2000
"""Most points that the mixture is fitted to."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """q. selected: (q,) coordinates S; mixture: in S."""

    dimension: int
    selected: NDArray[np.int64]
    mixture: Mixture

    def draw(self, rng: np.random.Generator, count: int) -> Points:
        """Independent points of q, each with a key of its noise."""
        z = rng.standard_normal((count, self.dimension))
        tilted = rng.random(count) >= DEFENSIVE
        if len(self.selected):
            z[np.ix_(tilted, self.selected)] = self.mixture.draw(rng, int(tilted.sum()))
        return Points(z, rng.integers(KEYS, size=count))

    def weights(self, z: Values) -> Values:
        """(n,) φ/q at z (n, d)."""
        x = z[:, self.selected]
        log_phi = -0.5 * np.sum(x * x, axis=1) - 0.5 * x.shape[1] * math.log(2.0 * math.pi)
        ratio = self.mixture.log_density(x) - log_phi if len(self.selected) else np.zeros(len(z))
        return np.exp(-np.logaddexp(math.log(DEFENSIVE), math.log1p(-DEFENSIVE) + ratio))


def select(z: Values, independent: int) -> NDArray[np.int64]:
    """The coordinates whose mean or variance differs from 0 or 1. z: (n, d) failing points, worth `independent` independent
    ones.
    """
    size = min(independent, len(z))
    mean = np.abs(np.mean(z, axis=0)) * math.sqrt(size)
    variance = np.abs(np.var(z, axis=0) - 1.0) * math.sqrt(size / 2.0)
    limit = -float(scipy.special.ndtri(SELECTION / (4 * z.shape[1])))  # 2 d tests of two sides
    return np.flatnonzero((mean > limit) | (variance > limit))


def usual(dimension: int) -> Proposal:
    """The law N(0, I) itself: every weight is 1."""
    return Proposal(dimension, np.zeros(0, dtype=np.int64), Mixture(np.ones(1), np.zeros((1, 0)), np.ones(1)))


def learn(z: Values, independent: int, seed: int) -> Proposal:
    """q from failing points z (n, d) of N(0, I), worth `independent` independent ones. ValueError without two points."""
    if len(z) < 2:
        raise ValueError(f"at least two failing points are needed; found {len(z)}")
    rng = np.random.default_rng([seed, 2])
    selected = select(z, independent)
    few = z if len(z) <= LEARNED else z[rng.choice(len(z), LEARNED, replace=False)]
    x = few[:, selected]
    if not len(selected):
        return usual(z.shape[1])
    mixture = fit(x, MOST_PARTS, rng, min(independent, len(few)))
    return Proposal(z.shape[1], selected, Mixture(mixture.shares, mixture.means, INFLATION * mixture.variances))


@dataclass(frozen=True)
class Weighed:
    """blocks: unbiased estimates, each from a block of flights. failing: flights that failed. effective: sample size of their
    weights. largest: the largest weight in shares of their sum. shape: Pareto k̂."""

    blocks: tuple[float, ...]
    flights: int
    failing: int
    effective: float
    largest: float
    shape: float

    def refusals(self) -> list[str]:
        """Why the estimate cannot be trusted, in words; empty where nothing speaks against it."""
        why: list[str] = []
        if not self.effective >= LEAST_EFFECTIVE:
            why.append(f"the effective sample size of the failing weights is {self.effective:.3g}, below {LEAST_EFFECTIVE:g}")
        if self.largest > LARGEST_SHARE:
            why.append(f"one weight is {100 * self.largest:.3g} % of their sum, more than {100 * LARGEST_SHARE:g} %")
        if self.shape > HEAVIEST:
            why.append(f"the weights have a heavy tail: Pareto k = {self.shape:.2f}, above {HEAVIEST:g}")
        return why


def weigh(proposal: Proposal, points: Points, margins: Values, blocks: int) -> Weighed:
    """The estimate of flights at independent points of q, in blocks of nearly equal size."""
    terms = np.where(failed(margins), proposal.weights(points.z), 0.0)
    failing = terms[terms > 0.0]
    total = float(failing.sum())
    return Weighed(
        blocks=tuple(float(part.mean()) for part in np.array_split(terms, blocks)),  # each is unbiased
        flights=len(terms),
        failing=len(failing),
        effective=total**2 / float(np.sum(failing**2)) if total > 0.0 else 0.0,
        largest=float(failing.max()) / total if total > 0.0 else 0.0,
        shape=tail_index(failing),
    )


def disagreement(weighed: Weighed, split: tuple[float, ...]) -> tuple[Estimate, Estimate] | None:
    """The intervals of importance sampling and of splitting where they have no number in common at joint 99 %; None otherwise."""
    confidence = 1.0 - (1.0 - AGREEMENT) / 2.0
    ours, theirs = student_interval(weighed.blocks, confidence), student_interval(split, confidence)
    return None if ours.low <= theirs.high and theirs.low <= ours.high else (ours, theirs)
