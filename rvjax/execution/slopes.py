"""Which tolerance to tighten: how the failure probabilities of a finished run change with every parameter of its laws.

The slopes are those of `rvjax.stats.slopes`; each table has intervals that hold for all of its rows together (Bonferroni).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.analysis.verdicts.sentences import title
from rvjax.campaign.law_words import in_words
from rvjax.columns import draw_column
from rvjax.components.samplers import sampling_design_of
from rvjax.errors import CampaignError, UsageError
from rvjax.execution.reweigh import CAPTURED, check_whole, complete, table
from rvjax.places import Place
from rvjax.simulation.law_checks import hindrance, numbers_of
from rvjax.simulation.problem import Problem, load
from rvjax.stats import Estimate, clopper_pearson
from rvjax.stats.sampling_design import Independent
from rvjax.stats.slopes import Slope, parameters, slope


@dataclass(frozen=True)
class Row:
    """A parameter of the law of a variable. change: of the failure probability per `slope.step`, None without a slope."""

    draw: str
    slope: Slope

    @property
    def is_clear(self) -> bool:
        """Whether the interval of the slope is on one side of 0."""
        estimate = self.slope.estimate
        return estimate is not None and not estimate.low <= 0.0 <= estimate.high

    @property
    def change(self) -> float:
        """Of the failure probability where the parameter grows by its step; 0 without a slope."""
        return 0.0 if self.slope.estimate is None else self.slope.estimate.value * self.slope.step


@dataclass(frozen=True)
class Slopes:
    """name: of the requirement. failing: share that does not comply. rows: clear ones first, each the largest change
    first."""

    name: str
    failing: Estimate
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class SlopesOfRun:
    """n: samples; tables: of each requirement; left_out: draws and requirements without slopes, each with the reason."""

    n: int
    tables: tuple[Slopes, ...]
    left_out: dict[str, str]


def slopes(place: str | Place, confidence: float = 0.95) -> SlopesOfRun:
    """The slopes of every requirement on a share over every parameter of the laws of the draws.

    IncompleteError if samples are missing; CampaignError where the samples are not independent or stopped when they were decided;
    UsageError where no draw has a parameter with a slope.
    """
    folder = complete(place)
    problem = load(folder.campaign_source(), [str(item) for item in folder.provenance.get("overrides", ())])
    if not isinstance(sampling_design_of(problem.spec), Independent):
        message = f"samples of {problem.spec.sampler.use} are not independent"
        raise CampaignError([problem.spec.source.finding(("sampler",), message, "accepted: sampler: {use: monte-carlo}")])
    check_whole(folder, problem)
    left_out: dict[str, str] = {}
    laws = {name: (draws, law) for name, draws, law in _laws(problem, left_out)}
    if not laws:
        raise UsageError(f"{place}: no draw has a law whose parameters have slopes; accepted: a run with such draws")
    evaluators: list[RequirementEvaluator] = []
    for requirement in (CAPTURED, *problem.spec.require):
        if requirement.mean or requirement.where or requirement.under:
            left_out[title(requirement)] = "a requirement on a mean, on a class or under a law"
        elif requirement.metric != "captured" or requirement is CAPTURED:
            evaluators.append(RequirementEvaluator(requirement))
    frame = table(folder, evaluators, (draw for draws, _ in laws.values() for draw in draws))
    return SlopesOfRun(len(frame), tuple(_table(evaluator, frame, laws, confidence) for evaluator in evaluators), left_out)


def _laws(problem: Problem, left_out: dict[str, str]) -> Iterator[tuple[str, tuple[str, ...], Any]]:
    """Name, draws and law of every variable whose law has parameters with slopes."""
    for name, numbers in numbers_of(problem).items():
        quantity = numbers.quantity
        if quantity.joint is not None:
            variables = [(name, quantity.names(name), quantity.joint)]
        else:
            parts = zip(quantity.names(name), quantity.parts, strict=True)
            variables = [(component, (component,), law) for component, law in parts if law.uniforms]
        for variable, draws, law in variables:
            obstacle = hindrance(problem, variable, tuple(draws), numbers)
            if obstacle is not None:
                left_out[variable] = obstacle[0]
            elif not parameters(law):
                left_out[variable] = f"{in_words(law)} has no parameter with a slope"
            elif all(draw in problem.dispersions.columns for draw in draws):
                yield variable, tuple(draws), law


def _table(
    evaluator: RequirementEvaluator, frame: pd.DataFrame, laws: dict[str, tuple[tuple[str, ...], Any]], confidence: float
) -> Slopes:
    failing = ~evaluator.comply(evaluator.values(frame, {}))
    each = 1.0 - (1.0 - confidence) / sum(len(parameters(law)) for _, law in laws.values())
    rows = [
        Row(name, slope(law, parameter, _values(frame, draws), failing, each))
        for name, (draws, law) in laws.items()
        for parameter in parameters(law)
    ]
    share = clopper_pearson(int(np.count_nonzero(failing)), len(frame), confidence)
    name = "not captured" if evaluator.requirement is CAPTURED else f"not: {title(evaluator.requirement)}"
    return Slopes(
        name, share, tuple(sorted(rows, key=lambda row: (not row.is_clear, -abs(row.change), row.draw, row.slope.parameter)))
    )


def _values(frame: pd.DataFrame, draws: tuple[str, ...]) -> NDArray[np.float64]:
    columns = [frame[draw_column(draw)].to_numpy(dtype=float) for draw in draws]
    return columns[0] if len(columns) == 1 else np.stack(columns, axis=1)
