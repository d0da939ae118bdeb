"""Random: x ~ U[0, 1]^d, every candidate independent of all others; the start of the campaign comes first.

The yardstick of the other methods: after n candidates the best of them is among the best share q of all there are with the
probability 1 − (1 − q)^n, whatever the objective and however many axes (J. Bergstra, Y. Bengio, J. Machine Learning Research 13,
2012). 59 candidates find one of the best 5 % with 95 %. Candidate k depends on the seed and on k alone, so more candidates are
the same ones and further ones.
"""

from __future__ import annotations

import numpy as np

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.components.search_methods.interface import Evaluate, Method, Task, Values
from rvjax.components.search_methods.point_sets import propose
from rvjax.stats.random_streams import uniforms


class Parameters(Model):
    """How they are proposed."""

    batch: int | None = count(default=None, at_least=1, doc="candidates at once; all of them if nothing is said")


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Proposes them all."""
    done = 0

    def following(points: int) -> Values:
        nonlocal done
        numbers = np.arange(done, done + points)
        done += points
        columns = [uniforms(task.seed, f"search:random:{index}", numbers)[:, 0] for index in range(len(task.axes))]
        return np.stack(columns, axis=1)

    propose(task, evaluate, following, parameters.batch)


COMPONENT = Method(Parameters, lambda parameters: lambda task, evaluate: search(parameters, task, evaluate))
