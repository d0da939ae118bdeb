"""Grid: every combination of levels, x_i ∈ {0, 1/(n−1), …, 1} of n levels.

Of one level it is the middle; an axis that has levels of its own has all of them (R. Fisher, "The design of experiments", 1935).
The axis that comes last changes from candidate to candidate. There are n^d of them, so it is for few axes; where one axis counts
and another does not, n² candidates see n values of the one that counts, those of other methods n². The start of the campaign is
no part of it. More combinations than the tuning may have candidates are an error: part of a grid would not see some axes at all.
"""

from __future__ import annotations

import math

import numpy as np

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.components.search_methods.interface import Axis, Evaluate, Method, Task, Values, snapped
from rvjax.errors import UsageError

MOST_POINTS = 10**6


class Parameters(Model):
    """The plan."""

    levels: int = count(default=5, at_least=1, at_most=MOST_POINTS, doc="of each axis that has none of its own")
    batch: int | None = count(default=None, at_least=1, doc="candidates at once; all of them if nothing is said")


def values(axis: Axis, levels: int) -> Values:
    """(n,) the coordinates of one axis."""
    if axis.levels:
        return (np.arange(axis.levels) + 0.5) / axis.levels
    return np.linspace(0.0, 1.0, levels) if levels > 1 else np.array([0.5])


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Proposes them all.

    Errors: UsageError if there are more combinations than candidates.
    """
    columns = [values(axis, parameters.levels) for axis in task.axes]
    shape = [len(column) for column in columns]
    points = math.prod(shape)
    most = MOST_POINTS if task.candidates is None else min(task.candidates, MOST_POINTS)
    if points > most:
        counts = " · ".join(map(str, shape))
        raise UsageError(f"a grid of {points:,} candidates ({counts}); accepted: at most {most:,}, so fewer levels or axes")
    batch = parameters.batch or points
    for first in range(0, points, batch):
        places = np.unravel_index(np.arange(first, min(first + batch, points)), shape)
        chosen = [column[place] for column, place in zip(columns, places, strict=True)]
        evaluate(snapped(task.axes, np.stack(chosen, axis=1)))


COMPONENT = Method(Parameters, lambda parameters: lambda task, evaluate: search(parameters, task, evaluate))
