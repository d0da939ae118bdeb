"""NSGA-II: generations of candidates that spread along the front where no objective improves without another that worsens.

Of a generation and its parents, those live on that are dominated by the fewest layers of others, and of the last layer those with
the most room around them. A candidate that misses constraints is dominated by every one that misses less in sum. Children: of two
parents by simulated binary crossover, then mutated by a polynomial law (K. Deb, A. Pratap, S. Agarwal, T. Meyarivan, IEEE Trans.
Evol. Comput. 6, 2002); of the package Optuna. The first generation is random, after the start of the campaign. A front takes some
tens of generations. For several objectives; of one, it is a genetic algorithm, and others need fewer candidates.
"""

from __future__ import annotations

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.components.search_methods.interface import Evaluate, Method, Task, snapped
from rvjax.components.search_methods.optuna_studies import Space, imported, silent, study_of
from rvjax.components.search_methods.point_sets import SEEDS, number

FEWEST = 4


class Parameters(Model):
    """Of a generation."""

    population: int = count(default=32, at_least=FEWEST, doc="candidates of a generation, all at once")


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Generation after generation, in one study."""
    imported("nsga")
    from optuna.samplers import NSGAIISampler
    from optuna.samplers.nsgaii import PolynomialMutation, SBXCrossover

    space, seed = Space(task.axes), number(task.seed, "search:nsga") % SEEDS
    distributions = space.distributions
    with silent():
        operators = {"crossover": SBXCrossover(), "mutation": PolynomialMutation()}
        study = study_of(NSGAIISampler(population_size=parameters.population, seed=seed, **operators), task.objectives)
        if task.start is not None:
            study.enqueue_trial(space.parameters(task.start))
    while True:
        with silent():
            asked = [study.ask(distributions) for _ in range(parameters.population)]
        told = evaluate(snapped(task.axes, space.points(asked)))
        with silent():
            for one, violation, objectives in zip(asked, told.violation, told.objectives, strict=True):
                one.set_constraint("violation", float(violation))
                study.tell(one, [float(value) for value in objectives])


COMPONENT = Method(Parameters, lambda parameters: lambda task, evaluate: search(parameters, task, evaluate), several=True)
