"""NSGA-II: generations of candidates that spread along the Pareto front, where no objective improves unless another worsens.

Of a generation and its parents, the best non-dominated fronts survive, and of the last front the candidates with the largest
crowding distance. A candidate with a larger sum of constraint violations is dominated. Children: simulated binary crossover of
two parents, then polynomial mutation (K. Deb, A. Pratap, S. Agarwal, T. Meyarivan, IEEE Trans. Evol. Comput. 6, 2002). From the
package Optuna. The first generation is random, after the original campaign. A front takes some tens of generations. Meant for
several objectives; for a single objective the other methods need fewer candidates.
"""

from __future__ import annotations

from functools import partial

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.components.search_methods.interface import Evaluate, Method, Task, snapped
from rvjax.components.search_methods.optuna_studies import Space, problems, silent, study_of
from rvjax.components.search_methods.point_sets import SEEDS, number

FEWEST = 4


class Parameters(Model):
    """Size of a generation."""

    population: int = count(default=32, at_least=FEWEST, doc="candidates per generation, all in a batch")


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """Proposes generations, all in the same study."""
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
        results = evaluate(snapped(task.axes, space.points(asked)))
        with silent():
            for candidate, violation, objectives in zip(asked, results.violation, results.objectives, strict=True):
                candidate.set_constraint("violation", float(violation))
                study.tell(candidate, [float(value) for value in objectives])


COMPONENT = Method(
    Parameters,
    lambda parameters: partial(search, parameters),
    several=True,
    packages=("optuna",),
    problems=lambda parameters, axes, candidates: problems("nsga"),
)
