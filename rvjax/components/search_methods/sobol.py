"""Sobol: x = a scrambled Sobol sequence, a dimension for each axis; the original campaign comes first.

Every 2^m points of the sequence are spread evenly over the cube, so they cover the ranges with fewer candidates than a grid or
independent points (I. Sobol 1967; scrambling: J. Matoušek, J. Complexity 14, 1998; for tuning: J. Bergstra, Y. Bengio, J. Machine
Learning Research 13, 2012). Best budget: 2^m candidates, plus the original campaign. Results do not change the proposals; the
search uses the whole budget.
"""

from __future__ import annotations

from functools import partial

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.components.search_methods.interface import Evaluate, Method, Task
from rvjax.components.search_methods.point_sets import number, propose, spread


class Parameters(Model):
    """Batch of the proposals."""

    batch: int | None = count(default=None, at_least=1, doc="candidates per batch; null: all at once")


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Proposes all candidates."""
    propose(task, evaluate, spread(len(task.axes), number(task.seed, "search:sobol")), parameters.batch)


COMPONENT = Method(Parameters, lambda parameters: partial(search, parameters))
