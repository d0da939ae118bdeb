"""Random: x ~ U[0, 1]^d, candidates independent of each other; the original campaign comes first.

The baseline of the other methods: after n candidates, the best of them is in the best share q of the cube with probability
1 − (1 − q)^n, for any objective and any number of axes (J. Bergstra, Y. Bengio, J. Machine Learning Research 13, 2012). 59
candidates hit the best 5 % with 95 %. Candidate k depends only on the seed and k, so a larger budget keeps the candidates of a
smaller budget.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.components.search_methods.interface import Evaluate, Method, Task, Values
from rvjax.components.search_methods.point_sets import propose
from rvjax.stats.random_streams import uniforms


class Parameters(Model):
    """Batch of the proposals."""

    batch: int | None = count(default=None, at_least=1, doc="candidates per batch; null: all at once")


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Proposes all candidates."""
    done = 0

    def following(points: int) -> Values:
        nonlocal done
        numbers = np.arange(done, done + points)
        done += points
        columns = [uniforms(task.seed, f"search:random:{index}", numbers)[:, 0] for index in range(len(task.axes))]
        return np.stack(columns, axis=1)

    propose(task, evaluate, following, parameters.batch)


COMPONENT = Method(Parameters, lambda parameters: partial(search, parameters))
