"""Gaussian copula: u_i' = Φ(x_i),   x = L z,   z_j = Φ⁻¹(u_j),   L Lᵀ = R.

u_j: uniform number of variable j, from any sampler; R: correlations of the normal numbers x. Every u_i' is uniform again, so the
distribution of each variable does not change.
Tied variables share a number, u or 1 − u. Variables are sorted by name, so their order in the campaign does not matter
(A. Sklar 1959; R. Nelsen, "An Introduction to Copulas", Springer, 2006).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from rvjax.campaign.correlation import Correlation, Matrix, ties
from rvjax.components.samplers.interface import Points, Values
from rvjax.elementary import ndtr, ndtri

LEAST, MOST = 2.0**-54, 1.0 - 2.0**-53
"""Smallest and largest number of a stream."""


@dataclass(frozen=True)
class Group:
    """A group of correlated variables. names: sorted; factor: L, lower triangular, of the variables that are tied to no earlier
    variable; free: their names; tied: of each variable its place among them, and whether it falls as that variable rises."""

    names: tuple[str, ...]
    factor: Matrix
    free: tuple[str, ...]
    tied: tuple[tuple[int, bool], ...]

    @classmethod
    def of(cls, correlation: Correlation) -> Group:
        """The group of an entry of `correlate`."""
        names, matrix = correlation.normal
        leaders = ties(matrix)
        free = [i for i, (leader, _) in enumerate(leaders) if leader == i]
        factor = cholesky(tuple(tuple(matrix[i][j] for j in free) for i in free))
        tied = tuple((free.index(leader), sign < 0.0) for leader, sign in leaders)
        return cls(names, factor, tuple(names[i] for i in free), tied)


def cholesky(matrix: Matrix) -> Matrix:
    """L with L Lᵀ = A, for A positive definite; bit-equal on every machine."""
    rows: list[list[float]] = []
    for i, row in enumerate(matrix):
        entries: list[float] = []
        for j in range(i + 1):
            rest = row[j] - math.fsum(entries[k] * (entries if i == j else rows[j])[k] for k in range(j))
            entries.append(math.sqrt(rest) if i == j else rest / rows[j][j])
        rows.append(entries)
    return tuple(tuple(row) for row in rows)


class Correlated:
    """Points with correlated groups."""

    def __init__(self, points: Points, groups: Iterable[Group]) -> None:
        self._points = points
        self._places = {name: (group, *tie) for group in groups for name, tie in zip(group.names, group.tied, strict=True)}

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1). Variables outside groups, and the first of a group, keep the sampler's numbers. A
        variable that falls as another rises has 1 − u."""
        if name not in self._places:
            return self._points.uniforms(name, count)
        group, place, falls = self._places[name]
        numbers = self._free(group, place)
        return np.clip(1.0 - numbers, LEAST, MOST) if falls else numbers

    def _free(self, group: Group, place: int) -> Values:
        """(samples, 1) numbers of a variable that is tied to no earlier one."""
        if place == 0:
            return self._points.uniforms(group.free[0], 1)
        parts = [
            weight * ndtri(self._points.uniforms(other, 1)[:, 0])
            for weight, other in zip(group.factor[place], group.free, strict=False)
            if weight
        ]
        return np.clip(ndtr(sum(parts)), LEAST, MOST)[:, None]

    def prescribed(self, name: str) -> Values | None:
        """(samples,) values of a draw that the sampler prescribes, else None."""
        return self._points.prescribed(name)
