"""Sobol: x = a scrambled Sobol sequence, one dimension for each axis; the start of the campaign comes first.

Every 2^m points of the sequence are spread evenly over the cube, so all of the ranges are seen with fewer candidates than a grid
or independent points need (I. Sobol 1967; scrambling: J. Matoušek, J. Complexity 14, 1998; for tuning: J. Bergstra, Y. Bengio,
J. Machine Learning Research 13, 2012). Take a power of two of them, and one for the start. Nothing that is told changes what is
proposed; candidates are as many as the tuning may have.
"""

from __future__ import annotations

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.components.search_methods.interface import Evaluate, Method, Task
from rvjax.components.search_methods.point_sets import number, propose, spread


class Parameters(Model):
    """How they are proposed."""

    batch: int | None = count(default=None, at_least=1, doc="candidates at once; all of them if nothing is said")


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Proposes them all."""
    propose(task, evaluate, spread(len(task.axes), number(task.seed, "search:sobol")), parameters.batch)


COMPONENT = Method(Parameters, lambda parameters: lambda task, evaluate: search(parameters, task, evaluate))
