"""TPE: candidates where l(x)/g(x) is largest, l the density of the better points so far and g of the others.

Both are mixtures of one normal law, or law of levels, for each point that was told, over all axes together. Of n points, the best
min(⌈n/10⌉, 25) are the better ones (J. Bergstra, R. Bardenet, Y. Bengio, B. Kégl, NIPS 2011; S. Watanabe, arXiv:2304.11127,
2023). Candidates of the same batch stay away from each other: until one is told, it counts as a bad one. Points are ordered by
the sum of missed constraints, then by the first objective, then by the next, and only their order counts. For expensive
candidates, few of them and choices; of the package Optuna. The first batch, and the first ten candidates, are random, after the
start of the campaign.
"""

from __future__ import annotations

import numpy as np

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.components.search_methods.interface import Evaluate, Method, Task, Told, Values, snapped
from rvjax.components.search_methods.optuna_studies import Space, imported, silent, study_of
from rvjax.components.search_methods.point_sets import SEEDS, number


class Parameters(Model):
    """How they are proposed."""

    batch: int = count(default=16, at_least=1, doc="candidates at once; fewer learn more from each other")


def ranks(told: list[Told]) -> Values:
    """(points,) the order of everything told so far, the best 0, equal ones alike."""
    rows = np.concatenate([np.column_stack([one.violation, one.objectives]) for one in told])
    return np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1).astype(float)


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Batch after batch, each from a study of all points before it, so that its ranks are those of now."""
    imported("tpe")
    space, points, told = Space(task.axes), np.empty((0, len(task.axes))), list[Told]()
    while True:
        first = task.start[None] if task.start is not None and not told else points[:0]
        asked = propose(space, points, told, parameters.batch - len(first), number(task.seed, f"search:tpe:{len(told)}"))
        batch = snapped(task.axes, np.concatenate([first, asked]))
        told.append(evaluate(batch))
        points = np.concatenate([points, batch])


def propose(space: Space, points: Values, told: list[Told], size: int, key: int) -> Values:
    """(size, d) the next points after those that were told."""
    from optuna.samplers import TPESampler
    from optuna.trial import create_trial

    if not size:
        return points[:0]
    distributions = space.distributions
    with silent():
        study = study_of(TPESampler(multivariate=True, constant_liar=True, seed=key % SEEDS))
        for point, rank in zip(points, ranks(told) if told else (), strict=True):
            known = create_trial(params=space.parameters(point), distributions=distributions, value=float(rank))
            study.add_trial(known)
        return space.points([study.ask(distributions) for _ in range(size)])


COMPONENT = Method(Parameters, lambda parameters: lambda task, evaluate: search(parameters, task, evaluate))
