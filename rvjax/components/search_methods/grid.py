"""Grid: every combination of levels, x_i ∈ {0, 1/(n−1), …, 1} for n levels.

A single level is the middle of the range; whole numbers and choices take all their values (R. Fisher, "The design of
experiments", 1935). The last axis changes from candidate to candidate. A grid has n^d candidates, so it suits few axes. If of two
axes only the first matters, n² candidates try n values of it, where other methods try n². The original campaign is not part of
the grid. More combinations than candidates in the budget are an error, because part of a grid leaves some axes untried.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.campaign.problems import Problem
from rvjax.components.search_methods.interface import Axis, Evaluate, Method, Task, Values, snapped
from rvjax.errors import UsageError

MOST_POINTS = 10**6


class Parameters(Model):
    """Levels and batch."""

    levels: int = count(default=5, at_least=1, at_most=MOST_POINTS, doc="levels of each continuous axis")
    batch: int | None = count(default=None, at_least=1, doc="candidates per batch; null: all at once")


def values(axis: Axis, levels: int) -> Values:
    """(n,) the coordinates of an axis."""
    if axis.levels:
        return (np.arange(axis.levels) + 0.5) / axis.levels
    return np.linspace(0.0, 1.0, levels) if levels > 1 else np.array([0.5])


def shape(axes: Sequence[Axis], levels: int) -> list[int]:
    """The number of coordinates of each axis."""
    return [axis.levels or levels for axis in axes]


def problems(parameters: Parameters, axes: Sequence[Axis], candidates: int | None) -> Iterable[Problem]:
    """A grid of more candidates than the budget allows."""
    counts = shape(axes, parameters.levels)
    points, most = math.prod(counts), MOST_POINTS if candidates is None else min(candidates, MOST_POINTS)
    if points <= most:
        return
    fewer = _most_levels(axes, most)
    ways = [f"levels: {fewer}"] if fewer else []
    ways += [f"a budget of {points} candidates"] if points <= MOST_POINTS else []
    accepted = f"accepted: at most {most}; use {' or '.join(ways or ['fewer axes'])}"
    yield Problem(f"a grid of {points:,} candidates ({' · '.join(map(str, counts))})", accepted, ("levels",))


def _most_levels(axes: Sequence[Axis], most: int) -> int:
    """The largest number of levels that keeps the grid within the number of candidates; 0 if there is none."""
    smooth = sum(not axis.levels for axis in axes)
    room = most // math.prod(axis.levels for axis in axes if axis.levels)
    if not smooth or not room:
        return 0
    levels = max(1, round(room ** (1.0 / smooth)))
    return levels if levels**smooth <= room else levels - 1


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Proposes the whole grid.

    Errors: UsageError if there are more combinations than candidates.
    """
    for problem in problems(parameters, task.axes, task.candidates):
        raise UsageError(f"{problem.message}; {problem.accepted}")
    columns = [values(axis, parameters.levels) for axis in task.axes]
    counts = [len(column) for column in columns]
    points = math.prod(counts)
    batch = parameters.batch or points
    for first in range(0, points, batch):
        places = np.unravel_index(np.arange(first, min(first + batch, points)), counts)
        chosen = [column[place] for column, place in zip(columns, places, strict=True)]
        evaluate(snapped(task.axes, np.stack(chosen, axis=1)))


COMPONENT = Method(Parameters, lambda parameters: partial(search, parameters), problems=problems)
