"""Gaussian copula: u_i' = Φ(x_i),   x = L z,   z_j = Φ⁻¹(u_j),   L Lᵀ = R.

u_j: the uniform number of variable j, whatever sampler gives it; R: correlations of the normal numbers x. Every u_i' is uniform
again, so the law of each variable stays what it is. Variables are in the order of their names, so the order in a file says
nothing (A. Sklar 1959; R. Nelsen, "An Introduction to Copulas", Springer, 2006).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri  # pyright: ignore[reportMissingTypeStubs]

from rvjax.campaign.correlation import Correlation, Matrix, normal_correlation
from rvjax.components.samplers.interface import Points, Values

LEAST, MOST = 2.0**-54, 1.0 - 2.0**-53
"""Ends of the numbers that a stream gives."""


@dataclass(frozen=True)
class Group:
    """names: of the variables, in rising order; factor: L, lower triangular."""

    names: tuple[str, ...]
    factor: Matrix

    @classmethod
    def of(cls, correlation: Correlation) -> Group:
        """The group that a campaign asks for."""
        names, rank = correlation.ordered
        return cls(names, cholesky(normal_correlation(rank)))


def cholesky(matrix: Matrix) -> Matrix:
    """L with L Lᵀ = A, for A positive definite; the same bits on every machine."""
    rows: list[list[float]] = []
    for i, row in enumerate(matrix):
        found: list[float] = []
        for j in range(i + 1):
            rest = row[j] - math.fsum(found[k] * (found if i == j else rows[j])[k] for k in range(j))
            found.append(math.sqrt(rest) if i == j else rest / rows[j][j])
        rows.append(found)
    return tuple(tuple(row) for row in rows)


class Correlated:
    """Points whose groups are correlated."""

    def __init__(self, points: Points, groups: Iterable[Group]) -> None:
        self._points = points
        self._rows = {name: (group, row) for group in groups for name, row in zip(group.names, group.factor, strict=True)}

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1); of a variable in no group, or the first of its group, the sampler's own."""
        group, row = self._rows.get(name, (None, ()))
        if group is None or len(row) == 1:
            return self._points.uniforms(name, count)
        parts = [
            weight * ndtri(self._points.uniforms(other, 1)[:, 0])
            for weight, other in zip(row, group.names, strict=False)
            if weight
        ]
        return np.clip(ndtr(sum(parts)), LEAST, MOST)[:, None]

    def given(self, name: str) -> Values | None:
        """(samples,) values of a draw that the sampler says."""
        return self._points.given(name)
