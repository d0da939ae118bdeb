"""CMA-ES: x ~ N(m, σ² C), a normal law that moves to where the better half of its candidates was, and takes on their shape.

    m' = m + Σ_i w_i (x_(i) − m),   x_(1), …, x_(λ) in the order of their ranks,   w_1 ≥ w_2 ≥ …

C follows the steps that were successful and σ the length of their path (N. Hansen, "The CMA evolution strategy: a tutorial",
arXiv:1604.00772, 2016). Whole numbers and choices have a margin, a least probability of another level, so that they do not freeze
(R. Hamano, S. Saito, M. Nomura, S. Shirakawa, GECCO 2022). Only the order of candidates is told: any objective of the same order
is searched in the same way, bit for bit, and a constraint costs nothing. A law that has become small, or sees no difference any
more, begins again from a random place with twice the population (IPOP: A. Auger, N. Hansen, CEC 2005), until the budget is used
up. The first candidates lie around the start of the campaign, or else the middle of the ranges.
"""

from __future__ import annotations

import math

import numpy as np
from cmaes import CMAwM

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.campaign.fields import number as parameter
from rvjax.components.search_methods.interface import Axis, Evaluate, Method, Task, Values, snapped
from rvjax.components.search_methods.point_sets import SEEDS, number

SMALL = 1e-6
"""Share of the range: candidates that differ by less are the same one."""

FEWEST = 4


class Parameters(Model):
    """The first law."""

    sigma: float = parameter("1", default=0.25, above=0.0, at_most=1.0, doc="σ at first, a share of the range")
    population: int | None = count(
        default=None, at_least=FEWEST, doc="candidates at once λ; 4 + ⌊3 ln d⌋, rounded up to a multiple of 8, if nothing is said"
    )


def usual(dimensions: int) -> int:
    """The population if nothing is said: Hansen's, and then as many as a batch takes without another row of eight."""
    return 8 * math.ceil((4 + math.floor(3 * math.log(dimensions))) / 8)


def law(axes: list[Axis], mean: Values, sigma: float, population: int, seed: int) -> CMAwM:
    """The first law of a run: of axes of levels, from the lowest level to the highest, in steps of one."""
    steps = np.array([1.0 / axis.levels if axis.levels else 0.0 for axis in axes])
    bounds = np.stack([steps / 2.0, 1.0 - steps / 2.0], axis=1)
    inside = np.clip(mean, bounds[:, 0], bounds[:, 1])
    return CMAwM(inside, sigma, bounds, steps, seed=seed, population_size=population)


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """One run after another, each with twice the population."""
    moving = np.array([axis.levels != 1 for axis in task.axes])
    axes = [axis for axis in task.axes if axis.levels != 1]
    middle = np.full(len(task.axes), 0.5) if task.start is None else task.start
    if not axes:
        evaluate(snapped(task.axes, middle[None]))
        return
    population, mean, run = parameters.population or usual(len(axes)), middle[moving], 0
    while True:
        key = number(task.seed, f"search:cma-es:{run}")
        law_now = law(axes, mean, parameters.sigma, population, key % SEEDS)
        converge(law_now, task, moving, evaluate)
        mean = np.random.Generator(np.random.Philox(np.random.SeedSequence(key))).random(len(axes))
        population, run = 2 * population, run + 1


def converge(law: CMAwM, task: Task, moving: np.ndarray, evaluate: Evaluate) -> None:
    """Generations until the law says that it is at its end, or is small in every axis without levels."""
    smooth = np.array([axis.levels == 0 for axis in task.axes])
    while not law.should_stop():
        asked = [law.ask() for _ in range(law.population_size)]
        points = np.full((len(asked), len(task.axes)), 0.5)
        points[:, moving] = [meant for meant, _ in asked]
        told = evaluate(snapped(task.axes, points))
        law.tell([(drawn, float(rank)) for (_, drawn), rank in zip(asked, told.rank, strict=True)])
        if smooth.any() and np.ptp(points[:, smooth], axis=0).max() < SMALL:
            return


COMPONENT = Method(Parameters, lambda parameters: lambda task, evaluate: search(parameters, task, evaluate))
