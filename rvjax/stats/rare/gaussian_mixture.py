"""Mixtures of round normal laws, fitted by expectation-maximisation; their number by the Bayesian information criterion.

    f(x) = Σ_k a_k N(x; m_k, s_k² I),   x ∈ R^q        BIC = −2 ln f(x₁, …, x_n) + (K (q + 2) − 1) ln n

Sources: A. P. Dempster, N. M. Laird, D. B. Rubin, JRSS B 39 (1977) 1; G. Schwarz, Ann. Stat. 6 (1978) 461;
D. Arthur, S. Vassilvitskii, "k-means++", SODA (2007) 1027 (the starts).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]
from numpy.typing import NDArray

Values = NDArray[np.float64]

ITERATIONS, LEAST_VARIANCE = 60, 1e-2


@dataclass(frozen=True, eq=False)
class Mixture:
    """shares: (K,) a_k; means: (K, q) m_k; variances: (K,) s_k²."""

    shares: Values
    means: Values
    variances: Values

    def log_parts(self, x: Values) -> Values:
        """(n, K) ln a_k N(x; m_k, s_k² I) at x (n, q)."""
        squares = _squares(x, self.means)
        log_norm = np.log(self.shares) - 0.5 * x.shape[1] * np.log(2.0 * np.pi * self.variances)
        return np.asarray(log_norm - 0.5 * squares / self.variances)

    def log_density(self, x: Values) -> Values:
        """(n,) ln f at x (n, q)."""
        return np.asarray(scipy.special.logsumexp(self.log_parts(x), axis=1))

    def draw(self, rng: np.random.Generator, count: int) -> Values:
        """(count, q) independent points."""
        part = rng.choice(len(self.shares), count, p=self.shares)
        noise = rng.standard_normal((count, self.means.shape[1]))
        return self.means[part] + np.sqrt(self.variances[part])[:, None] * noise


def fit(x: Values, most: int, rng: np.random.Generator, independent: int | None = None) -> Mixture:
    """The mixture of 1 … `most` parts with the least BIC. x: (n, q). independent: n of the criterion where points are
    correlated.
    """
    best, least = None, math.inf
    for parts in range(1, min(most, max(1, len(x) // 10)) + 1):
        mixture = _fit(x, parts, rng)
        size = independent or len(x)
        parameters = parts * (x.shape[1] + 2) - 1
        criterion = -2.0 * size * float(np.mean(mixture.log_density(x))) + parameters * math.log(size)
        if criterion < least:
            best, least = mixture, criterion
    assert best is not None, "at least one part is tried"
    return best


def _fit(x: Values, parts: int, rng: np.random.Generator) -> Mixture:
    mixture = _start(x, parts, rng)
    for _ in range(ITERATIONS):
        logs = mixture.log_parts(x)
        members = np.exp(logs - scipy.special.logsumexp(logs, axis=1, keepdims=True))
        sizes = np.maximum(members.sum(axis=0), 1e-9)
        means = members.T @ x / sizes[:, None]
        squares = _squares(x, means)
        variances = np.sum(members * squares, axis=0) / (sizes * x.shape[1])
        mixture = Mixture(sizes / sizes.sum(), means, np.maximum(variances, LEAST_VARIANCE))
    return mixture


def _squares(x: Values, means: Values) -> Values:
    """(n, K) |x_i − m_k|²"""
    return np.maximum(np.sum(x * x, axis=1)[:, None] - 2.0 * x @ means.T + np.sum(means * means, axis=1), 0.0)


def _start(x: Values, parts: int, rng: np.random.Generator) -> Mixture:
    """Centres that are far from each other, with a common variance."""
    centres: list[Values] = [x[rng.integers(len(x))]]
    for _ in range(parts - 1):
        squares: Values = np.min(_squares(x, np.stack(centres)), axis=1)
        total = float(squares.sum())
        row = int(rng.choice(len(x), p=squares / total)) if total > 0.0 else int(rng.integers(len(x)))
        centres.append(x[row])
    nearest: Values = np.min(_squares(x, np.stack(centres)), axis=1)
    variance = max(float(np.mean(nearest)) / x.shape[1], LEAST_VARIANCE)
    return Mixture(np.full(parts, 1.0 / parts), np.stack(centres), np.full(parts, variance))
