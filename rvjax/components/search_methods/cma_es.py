"""CMA-ES: x ~ N(m, σ² C), a normal distribution whose mean and covariance follow the better half of its candidates.

    m' = m + Σ_i w_i (x_(i) − m),   x_(1), …, x_(λ) in the order of their ranks,   w_1 ≥ w_2 ≥ …

C adapts to the successful steps and σ to the length of their path (N. Hansen, "The CMA evolution strategy: a tutorial",
arXiv:1604.00772, 2016). Whole numbers and choices have a margin, a least probability of another level, so that they do not freeze
(R. Hamano, S. Saito, M. Nomura, S. Shirakawa, GECCO 2022). The method uses only the ranks of the candidates: a monotonic change
of the objective does not change the search, and constraints need no penalty weight. When the distribution has become small or
stagnates, it restarts at a random point with twice the population (IPOP: A. Auger, N. Hansen, CEC 2005), until the budget is used
up. The first candidates lie around the original campaign, or the middle of the ranges if it lies outside them.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from cmaes import CMAwM

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.campaign.fields import number as parameter
from rvjax.components.search_methods.interface import Axis, Evaluate, Method, Task, Values, snapped
from rvjax.components.search_methods.point_sets import SEEDS, number

SMALL = 1e-6
"""Share of the range below which candidates are taken as equal."""

FEWEST = 4


class Parameters(Model):
    """The first distribution."""

    sigma: float = parameter("1", default=0.25, above=0.0, at_most=1.0, doc="initial σ as a share of the range")
    population: int | None = count(
        default=None, at_least=FEWEST, doc="candidates λ per generation; null: 4 + ⌊3 ln d⌋ rounded up to a multiple of 8"
    )


def usual(dimensions: int) -> int:
    """Default population: Hansen's, rounded up to a multiple of 8."""
    return 8 * math.ceil((4 + math.floor(3 * math.log(dimensions))) / 8)


def distribution(axes: list[Axis], mean: Values, sigma: float, population: int, seed: int) -> CMAwM:
    """The distribution at the start of a run. An axis with levels goes from the lowest to the highest in steps of a level."""
    steps = np.array([1.0 / axis.levels if axis.levels else 0.0 for axis in axes])
    bounds = np.stack([steps / 2.0, 1.0 - steps / 2.0], axis=1)
    inside = np.clip(mean, bounds[:, 0], bounds[:, 1])
    return CMAwM(inside, sigma, bounds, steps, seed=seed, population_size=population)


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Runs in sequence, each with twice the population of the last."""
    moving = np.array([axis.levels != 1 for axis in task.axes])
    axes = [axis for axis in task.axes if axis.levels != 1]
    middle = np.full(len(task.axes), 0.5) if task.start is None else task.start
    if not axes:
        evaluate(snapped(task.axes, middle[None]))
        return
    population, mean, run = parameters.population or usual(len(axes)), middle[moving], 0
    while True:
        key = number(task.seed, f"search:cma-es:{run}")
        converge(distribution(axes, mean, parameters.sigma, population, key % SEEDS), task, moving, evaluate)
        mean = np.random.Generator(np.random.Philox(np.random.SeedSequence(key))).random(len(axes))
        population, run = 2 * population, run + 1


def converge(optimiser: CMAwM, task: Task, moving: np.ndarray, evaluate: Evaluate) -> None:
    """Generations until the optimiser stops or the candidates nearly agree in every axis without levels."""
    smooth = np.array([axis.levels == 0 for axis in task.axes])
    while not optimiser.should_stop():
        asked = [optimiser.ask() for _ in range(optimiser.population_size)]
        points = np.full((len(asked), len(task.axes)), 0.5)
        points[:, moving] = [point for point, _ in asked]
        results = evaluate(snapped(task.axes, points))
        optimiser.tell([(drawn, float(rank)) for (_, drawn), rank in zip(asked, results.rank, strict=True)])
        if smooth.any() and np.ptp(points[:, smooth], axis=0).max() < SMALL:
            return


COMPONENT = Method(Parameters, lambda parameters: partial(search, parameters), packages=("cmaes",))
