"""What a search is: it proposes points of the unit cube and is told what came of each, until whoever tells it has had enough.

A point has one coordinate in [0, 1] for each axis; the caller knows what value of a campaign that is. Everything that a search
does is a function of its axes, its start, its seed and what it was told, so that one that is stopped and begun again with the
same answers goes the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from rvjax.components.registry import Component, P

Values = NDArray[np.float64]


class Axis(NamedTuple):
    """One coordinate. levels: how many values it can have, the k-th of them at (k + ½)/levels; 0: every number in [0, 1].
    ordered: whether neighbouring levels are near each other, as whole numbers are and kinds of things are not."""

    levels: int = 0
    ordered: bool = True

    def snapped(self, x: Values) -> Values:
        """The coordinates that are meant: inside [0, 1], on a level where there are levels."""
        inside = np.clip(x, 0.0, 1.0)
        if not self.levels:
            return inside
        return (np.minimum(np.floor(inside * self.levels), self.levels - 1) + 0.5) / self.levels


def snapped(axes: Sequence[Axis], points: Values) -> Values:
    """(m, d) the points that are meant."""
    return np.column_stack([axis.snapped(column) for axis, column in zip(axes, points.T, strict=True)])


class Told(NamedTuple):
    """What came of m points, in the order in which they were proposed.

    violation: (m,) by how much constraints are missed, in sum; 0 where all hold. objectives: (m, k) each the smaller the better,
    +∞ where it cannot be said. rank: (m,) the order of these points among each other, the best 0, equal ones alike.
    gradient: (m, d) of the first objective, or of a smooth function in its place, where the search asks for it; else None.
    """

    violation: Values
    objectives: Values
    rank: Values
    gradient: Values | None = None


class Evaluate(Protocol):
    """Tells what comes of points. Raises `Spent` once the budget is used up; the search then ends."""

    def __call__(self, points: Values) -> Told:
        """points: (m, d) in [0, 1]."""
        ...


class Spent(Exception):
    """The budget is used up."""


@dataclass(frozen=True)
class Task:
    """What a search is to do. start: the point of the campaign as it is, where it lies inside the ranges. candidates: how many
    points there will be at most, where that is known."""

    axes: tuple[Axis, ...]
    seed: int
    start: Values | None = None
    candidates: int | None = None
    objectives: int = 1


Search = Callable[[Task, Evaluate], None]
"""Runs until `Spent` comes out of evaluate, which it lets pass, or until it has nothing left to propose."""


@dataclass(frozen=True)
class Method(Component[P]):
    """gradient: it needs gradients. several: it looks for a set of points where there are several objectives; the others follow
    the ranks."""

    gradient: bool = field(default=False, kw_only=True)
    several: bool = field(default=False, kw_only=True)
