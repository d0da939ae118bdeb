"""TPE: candidates where l(x)/g(x) is largest; l: density of the better points so far, g: density of the other points.

Both are mixtures with a component for each evaluated point, over all axes together: normal, or discrete for levels. Of n points,
the best min(⌈n/10⌉, 25) are the better ones (J. Bergstra, R. Bardenet, Y. Bengio, B. Kégl, NIPS 2011; S. Watanabe,
arXiv:2304.11127, 2023). A candidate without a result counts as bad, so the candidates of a batch keep apart. Points are ordered
by the sum of constraint violations, then by the first objective, then by the next; only this order matters. Suits few, expensive
candidates and choices. From the package Optuna. The first batch and the first ten candidates are random, after the original
campaign.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.components.search_methods.interface import Evaluate, Method, Results, Task, Values, snapped
from rvjax.components.search_methods.optuna_studies import Space, problems, silent, study_of
from rvjax.components.search_methods.point_sets import SEEDS, number


class Parameters(Model):
    """Batch of the proposals."""

    batch: int = count(default=16, at_least=1, doc="candidates per batch; small batches learn more from each candidate")


def ranks(results: list[Results]) -> Values:
    """(points,) rank of every point so far, the best 0, ties equal."""
    rows = np.concatenate([np.column_stack([batch.violation, batch.objectives]) for batch in results])
    return np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1).astype(float)


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Proposes batches, each from a new study of all points before it, because their ranks change."""
    space, points, results = Space(task.axes), np.empty((0, len(task.axes))), list[Results]()
    while True:
        first = task.start[None] if task.start is not None and not results else points[:0]
        key = number(task.seed, f"search:tpe:{len(results)}")
        asked = propose(space, points, results, parameters.batch - len(first), key)
        batch = snapped(task.axes, np.concatenate([first, asked]))
        results.append(evaluate(batch))
        points = np.concatenate([points, batch])


def propose(space: Space, points: Values, results: list[Results], size: int, key: int) -> Values:
    """(size, d) the next points; points, results: those so far."""
    from optuna.samplers import TPESampler
    from optuna.trial import create_trial

    if not size:
        return points[:0]
    distributions = space.distributions
    with silent():
        study = study_of(TPESampler(multivariate=True, constant_liar=True, seed=key % SEEDS))
        for point, rank in zip(points, ranks(results) if results else (), strict=True):
            known = create_trial(params=space.parameters(point), distributions=distributions, value=float(rank))
            study.add_trial(known)
        return space.points([study.ask(distributions) for _ in range(size)])


COMPONENT = Method(
    Parameters,
    lambda parameters: partial(search, parameters),
    packages=("optuna",),
    problems=lambda parameters, axes, candidates: problems("tpe"),
)
