"""Interface of a search method: it proposes points of the unit cube and gets their results, until the budget is used up.

A point has a coordinate in [0, 1] for each axis; the caller maps it to values of the campaign. A search depends only on its axes,
its start, its seed and the results, so a search that is restarted with the same results proposes the same points.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign.problems import Problem
from rvjax.components.registry import Component, P

Values = NDArray[np.float64]


class Axis(NamedTuple):
    """A coordinate. levels: number of its values, the k-th at (k + ½)/levels; 0: every number in [0, 1].

    ordered: whether neighbouring levels are similar, as with whole numbers; not so for choices.
    """

    levels: int = 0
    ordered: bool = True

    def snapped(self, x: Values) -> Values:
        """The coordinates moved into [0, 1] and, if there are levels, to their levels."""
        inside = np.clip(x, 0.0, 1.0)
        if not self.levels:
            return inside
        return (np.minimum(np.floor(inside * self.levels), self.levels - 1) + 0.5) / self.levels


def snapped(axes: Sequence[Axis], points: Values) -> Values:
    """(m, d) the points, each coordinate moved to an admissible value of its axis."""
    return np.column_stack([axis.snapped(column) for axis, column in zip(axes, points.T, strict=True)])


class Results(NamedTuple):
    """Results of m points, in the order of the proposal.

    violation: (m,) sum of the constraint violations, 0 if all hold. objectives: (m, k), smaller is better, +∞ if unknown.
    rank: (m,) rank within the m points, the best 0, ties equal. gradient: (m, d) of the first objective or of its smooth
    substitute, if the search needs gradients; else None.
    """

    violation: Values
    objectives: Values
    rank: Values
    gradient: Values | None = None


class Evaluate(Protocol):
    """Evaluates points. Raises `Spent` once the budget is used up; the search then ends."""

    def __call__(self, points: Values) -> Results:
        """points: (m, d) in [0, 1]."""
        ...


class Spent(Exception):
    """The budget is used up."""


@dataclass(frozen=True)
class Task:
    """The task of a search. start: point of the original campaign, if it is inside the ranges.

    candidates: largest number of points, if known.
    """

    axes: tuple[Axis, ...]
    seed: int
    start: Values | None = None
    candidates: int | None = None
    objectives: int = 1


Search = Callable[[Task, Evaluate], None]
"""Runs until it has nothing left to propose, or until evaluate raises `Spent`, which it does not catch."""


def _no_problem(parameters: Any, axes: Sequence[Axis], candidates: int | None) -> Iterable[Problem]:
    """Every search can begin."""
    del parameters, axes, candidates
    return ()


@dataclass(frozen=True)
class Method(Component[P]):
    """A search method. gradient: it needs gradients. several: it searches the front of several objectives, not the best rank.

    packages: distributions whose version may change the proposals. problems(parameters, axes, candidates): why a search with
    these axes and this budget cannot begin; places are those of the section `method`.
    """

    family: ClassVar[str] = "searches"

    gradient: bool = field(default=False, kw_only=True)
    several: bool = field(default=False, kw_only=True)
    packages: tuple[str, ...] = field(default=(), kw_only=True)
    problems: Callable[[P, Sequence[Axis], int | None], Iterable[Problem]] = field(default=_no_problem, kw_only=True)
