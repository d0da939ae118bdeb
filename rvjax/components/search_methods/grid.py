"""Grid: every combination of levels, x_i ∈ {0, 1/(n−1), …, 1} for n levels.

A single level is the middle of the range; whole numbers and choices take all their values (R. Fisher, "The design of
experiments", 1935). The last axis changes from candidate to candidate. A grid has n^d candidates, so it suits few axes. If of two
axes only the first matters, n² candidates try n values of it, where other methods try n². The original campaign is not part of
the grid. More combinations than candidates in the budget are an error, because part of a grid leaves some axes untried.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from rvjax.campaign import Model
from rvjax.campaign.fields import count
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


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Proposes the whole grid.

    Errors: UsageError if there are more combinations than candidates.
    """
    columns = [values(axis, parameters.levels) for axis in task.axes]
    shape = [len(column) for column in columns]
    points = math.prod(shape)
    most = MOST_POINTS if task.candidates is None else min(task.candidates, MOST_POINTS)
    if points > most:
        counts = " · ".join(map(str, shape))
        raise UsageError(f"a grid of {points:,} candidates ({counts}); accepted: at most {most:,}; use fewer levels or axes")
    batch = parameters.batch or points
    for first in range(0, points, batch):
        places = np.unravel_index(np.arange(first, min(first + batch, points)), shape)
        chosen = [column[place] for column, place in zip(columns, places, strict=True)]
        evaluate(snapped(task.axes, np.stack(chosen, axis=1)))


COMPONENT = Method(Parameters, lambda parameters: partial(search, parameters))
