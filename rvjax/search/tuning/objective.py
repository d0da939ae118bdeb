"""The score of a candidate on some samples, and whether a candidate is worse than another on the same samples.

    loss        x = X where small is good, −X where large is good; +∞ where the flight was lost
    mean        E x
    quantile    the q-quantile of X, as a loss
    cvar        E[x | x among the worst 1 − q of all]
    probability P(X does not comply)

    violation   Σ over requirements of (needed share − observed share)₊, of a mean (excess/limit)₊

The share that is needed is the one whose fresh samples pass with probability POWER: a candidate at the limit itself would pass on
them as often as not.

A candidate that violates less is better; of two that violate equally, the one with the smaller objective. Whether one is *worse*
is tested in pairs on the samples that both have flown:

    requirement, probability, quantile   McNemar's exact test of non-compliance, or of exceeding the better candidate's quantile
    mean, cvar                           Student's t of the differences of x, or of (x − t)₊/(1 − q), t the better candidate's
                                         quantile; McNemar's test of lost flights where there are any
    weighted sum                         z of the difference, its deviation by RESAMPLES bootstraps of the pairs

An objective is only compared with one that is shown to meet the requirements: of two that violate, or that may, the order of
their objectives is not what decides in the end.

McNemar's test is exact where the threshold is given; where it is a quantile of the same samples, and for t and z, the risk is
nominal.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import special

from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.analysis.verdicts.sentences import title
from rvjax.campaign import Requirement
from rvjax.campaign.plain_values import exact
from rvjax.campaign.tuning import Goal, Objective
from rvjax.columns import FAILED, Column, metric_column
from rvjax.run_folder.tuning_record import Missed
from rvjax.stats import clopper_pearson_lower, mcnemar, verdict_chances
from rvjax.stats.pareto import Score

Values = NDArray[np.float64]

RESAMPLES = 200

NO_COLUMNS: Mapping[str, Column] = {}

CONFIDENCE = 0.95
"""Confidence with which the better candidate must meet a requirement before objectives are compared."""

POWER = 0.9
"""Probability to pass on fresh draws that a candidate is asked for."""

REFUSED = math.inf
"""Violation of a candidate whose values the campaign does not accept together."""


@dataclass(frozen=True)
class Measure:
    """One objective. column: of the samples table; largest: whether the metric is to be large."""

    objective: Objective
    column: str
    unit: str
    largest: bool

    @classmethod
    def of(cls, objective: Objective, columns: Mapping[str, Column]) -> Measure:
        """The objective on these columns `metric.<name>`."""
        start = metric_column(objective.metric)
        column = start if start in columns else f"{start}.{objective.channel or 'any'}"
        about = columns[column]
        largest = objective.sense == "largest" if objective.sense else about.better == "higher"
        return cls(objective, column, about.unit, largest)

    def needs_sense(self, columns: Mapping[str, Column]) -> bool:
        """Whether nobody knows if the metric is to be small or large."""
        return not self.objective.sense and not self.objective.probability and not columns[self.column].better

    def losses(self, frame: pd.DataFrame) -> Values:
        """(n,) the smaller the better; for a probability whether a sample does not comply."""
        x = frame[self.column].to_numpy(dtype=float)
        lost = frame["outcome"].isin(FAILED).to_numpy() | np.isnan(x)
        if self.objective.probability:
            bound = self.objective.bound
            complies = bound.met_by(x) if bound else x > 0.5
            return np.where(complies & ~lost, 0.0, 1.0)
        return np.where(lost, np.inf, -x if self.largest else x)

    def value(self, x: Values) -> float:
        """Of losses (n,)."""
        objective = self.objective
        if objective.quantile is not None:
            return -quantile(-x, objective.quantile) if self.largest else quantile(x, objective.quantile)
        return tail_mean(x, objective.cvar) if objective.cvar is not None else float(np.mean(x))

    def shown(self, loss: float) -> float:
        """The value in the sense of the metric: a share that complies, a margin that is large."""
        if self.objective.probability:
            return 1.0 - loss
        return -loss if self.largest else loss

    def p_worse(self, x: Values, other: Values) -> float:
        """One-sided p-value of pairs against: x (n,) is not worse than `other`, whose value is smaller."""
        objective = self.objective
        if objective.probability:
            return _p_counts(x > 0.5, other > 0.5)
        if objective.mean:
            return _p_means(x, other)
        if objective.quantile is not None:
            threshold = self.value(other)
            return _p_counts(x > threshold, other > threshold)
        threshold = quantile(other, objective.cvar or 0.0)
        if not math.isfinite(threshold):
            return _p_counts(np.isinf(x), np.isinf(other))
        return _p_means(np.maximum(x - threshold, 0.0), np.maximum(other - threshold, 0.0))

    def __str__(self) -> str:
        objective = self.objective
        name = objective.metric + (f" ({objective.channel})" if objective.channel else "")
        if objective.probability:
            side = f" {objective.bound.side} {exact(objective.bound.value)}" if objective.bound else ""
            return f"share with {name}{side}"
        if objective.quantile is not None:
            return f"{exact(objective.quantile)} quantile of {name}"
        if objective.cvar is not None:
            tail = f"below its {exact(round(1.0 - objective.cvar, 12))}" if self.largest else f"above its {exact(objective.cvar)}"
            return f"mean of {name} {tail} quantile"
        return f"mean of {name}"


def quantile(x: Values, q: float) -> float:
    """The smallest value that a share q of them does not exceed."""
    rank = min(max(math.ceil(q * len(x) - 1e-9) - 1, 0), len(x) - 1)
    return float(np.partition(x, rank)[rank])


def tail_mean(x: Values, q: float) -> float:
    """(1/(1 − q)) ∫_q^1 quantile(u) du of the distribution of the values."""
    ordered, weight = np.sort(x)[::-1], (1.0 - q) * len(x)
    whole = min(int(weight), len(x) - 1)
    part = weight - whole
    total = float(np.sum(ordered[:whole])) + (part * float(ordered[whole]) if part > 1e-12 else 0.0)
    return total / weight


class Judge:
    """Scores and compares candidates by their tables, which hold the same samples in the same order."""

    def __init__(
        self, requirements: Sequence[Requirement], measures: Sequence[Measure], goal: Goal, fresh: int | None = None
    ) -> None:
        """fresh: samples of the confirmation; without, shares are only to be what is required."""
        self.requirements, self.measures = tuple(requirements), tuple(measures)
        self.goal: Goal = goal
        self._needed = [requirement.limit if fresh is None else needed(requirement, fresh) for requirement in requirements]
        self._readings = [RequirementEvaluator(requirement) for requirement in requirements]

    def columns(self, names: Sequence[str]) -> list[str]:
        """The columns that it needs beside sample and outcome."""
        needed = [
            *(measure.column for measure in self.measures),
            *(name for reading in self._readings for name in reading.columns(names)),
        ]
        return list(dict.fromkeys(needed))

    def score(self, frame: pd.DataFrame) -> Score:
        """The score of a candidate; with the weighted goal a single objective."""
        values = [measure.value(measure.losses(frame)) for measure in self.measures]
        violation = sum(self._shortfalls(frame))
        if self.goal == "weighted" and len(values) > 1:
            values = [self._sum(values)]
        return Score(violation, tuple(values))

    @property
    def objectives(self) -> int:
        """How many a score has."""
        return 1 if self.goal == "weighted" else len(self.measures)

    def total(self, losses: Sequence[Values]) -> float:
        """Of the losses of each objective, the weighted sum of their values."""
        return self._sum([measure.value(x) for measure, x in zip(self.measures, losses, strict=True)])

    def _sum(self, values: Sequence[float]) -> float:
        return sum(measure.objective.weight * value for measure, value in zip(self.measures, values, strict=True))

    def values(self, frame: pd.DataFrame) -> tuple[float, ...]:
        """Each objective by itself, as it is shown."""
        return tuple(measure.shown(measure.value(measure.losses(frame))) for measure in self.measures)

    def _shortfalls(self, frame: pd.DataFrame) -> list[float]:
        """By how much each requirement is missed."""
        required = zip(self.requirements, self._readings, self._needed, strict=True)
        return [self._shortfall(requirement, reading, share, frame) for requirement, reading, share in required]

    def missed(self, frame: pd.DataFrame, columns: Mapping[str, Column] = NO_COLUMNS) -> list[Missed]:
        """The requirements that the samples do not meet: a share below the required share, a mean beyond its bound.

        columns: of the table, for the units.
        """
        missed: list[Missed] = []
        for requirement, reading in zip(self.requirements, self._readings, strict=True):
            if self._shortfall(requirement, reading, requirement.limit, frame) > 0.0:
                values = reading.values(frame, columns)[reading.chosen(frame)]
                share = not requirement.mean
                observed = float(np.mean(reading.comply(values) if share else values))
                limit = requirement.limit if share else reading.bound.value
                missed.append(Missed(text=title(requirement), observed=observed, limit=limit, share=share, unit=reading.unit))
        return missed

    @staticmethod
    def _shortfall(requirement: Requirement, reading: RequirementEvaluator, share: float, frame: pd.DataFrame) -> float:
        values = reading.values(frame, {})[reading.chosen(frame)]
        if not values.size:
            return 0.0
        if not requirement.mean:
            return max(share - float(np.mean(reading.comply(values))), 0.0)
        bound = reading.bound
        mean = math.inf if np.isnan(values).any() else float(np.mean(values))
        excess = mean if math.isinf(mean) else bound.excess(mean)
        return max(excess, 0.0) / max(abs(bound.value), 1e-12)

    def p_worse(self, frame: pd.DataFrame, better: pd.DataFrame) -> float:
        """p-value of pairs against: the first is not worse than the second, which has the better score."""
        ours, theirs = self.score(frame), self.score(better)
        p_values: list[float] = []
        if ours.violation > theirs.violation:
            missed = zip(self._p_complies(frame, better), self._shortfalls(frame), self._shortfalls(better), strict=True)
            each = [p for p, here, there in missed if here > there]  # a requirement that both meet is no evidence of a violation
            p_values.append(min(1.0, len(each) * min(each)))
        if self.goal == "pareto":
            pairs = zip(self.measures, ours.objectives, theirs.objectives, strict=True)
            each = [m.p_worse(m.losses(frame), m.losses(better)) if a > b else 1.0 for m, a, b in pairs]
            p_values.append(max(each) if self.complies(better) else 1.0)
        elif ours.objectives > theirs.objectives and self.complies(better):
            p_values.append(self._p_objective(frame, better, ours, theirs))
        return min(1.0, len(p_values) * min(p_values)) if p_values else 1.0

    def complies(self, frame: pd.DataFrame) -> bool:
        """Whether the samples show, at CONFIDENCE for each requirement, that it is met. Until then nobody is worse for being
        slower than a candidate that may turn out to violate."""
        return all(
            self._shown(requirement, reading, frame)
            for requirement, reading in zip(self.requirements, self._readings, strict=True)
        )

    @staticmethod
    def _shown(requirement: Requirement, reading: RequirementEvaluator, frame: pd.DataFrame) -> bool:
        values = reading.values(frame, {})[reading.chosen(frame)]
        if not requirement.mean:
            return clopper_pearson_lower(int(np.sum(reading.comply(values))), len(values), CONFIDENCE) >= requirement.limit
        if len(values) < 2 or not np.isfinite(values).all():
            return False
        off = reading.bound.excess(float(np.mean(values)))
        deviation = float(np.std(values, ddof=1)) / math.sqrt(len(values))
        return float(special.stdtr(len(values) - 1, off / deviation)) <= 1.0 - CONFIDENCE if deviation > 0.0 else off <= 0.0

    def p_fails(self, frame: pd.DataFrame, better: pd.DataFrame) -> float:
        """p-value of pairs against: the first complies with the requirements, or is captured, as often as the second."""
        if not self.requirements:
            return _p_counts(*((table["outcome"] != "captured").to_numpy() for table in (frame, better)))
        return min(1.0, len(self.requirements) * min(self._p_complies(frame, better)))

    def _p_complies(self, frame: pd.DataFrame, better: pd.DataFrame) -> list[float]:
        p_values: list[float] = []
        for requirement, reading in zip(self.requirements, self._readings, strict=True):
            both = reading.chosen(frame) & reading.chosen(better)
            x, y = (reading.values(table, {})[both] for table in (frame, better))
            if requirement.mean:
                sign = reading.bound.sign
                p_values.append(_p_means(*(np.where(np.isnan(values), np.inf, sign * values) for values in (x, y))))
            else:
                p_values.append(_p_counts(~reading.comply(x), ~reading.comply(y)))
        return p_values

    def _p_objective(self, frame: pd.DataFrame, better: pd.DataFrame, ours: Score, theirs: Score) -> float:
        if self.goal == "weighted" and len(self.measures) > 1:
            return self._p_sum(*([measure.losses(table) for measure in self.measures] for table in (frame, better)))
        first = next(i for i, (a, b) in enumerate(zip(ours.objectives, theirs.objectives, strict=True)) if a != b)
        measure = self.measures[first]
        return measure.p_worse(measure.losses(frame), measure.losses(better))

    def _p_sum(self, ours: Sequence[Values], theirs: Sequence[Values]) -> float:
        n = len(ours[0])
        rows = np.random.default_rng(n).integers(n, size=(RESAMPLES, n))
        observed, *others = [
            self.total([x[row] for x in ours]) - self.total([y[row] for y in theirs]) for row in (np.arange(n), *rows)
        ]
        spread = np.array(others)
        if not np.isfinite(spread).all() or not math.isfinite(observed):
            return (1.0 + float(np.sum(~(spread > 0.0)))) / (RESAMPLES + 1.0)
        deviation = float(np.std(spread, ddof=1))
        return float(special.ndtr(-observed / deviation)) if deviation > 0.0 else 1.0


def needed(requirement: Requirement, fresh: int) -> float:
    """The smallest share of complying samples with which so many fresh ones PASS with probability POWER; the required share where
    none does, and of a class, of which nobody knows how many there will be."""
    limit = requirement.limit

    def passes(share: float) -> bool:
        return float(verdict_chances(fresh, limit, requirement.confidence, share).passes) >= POWER

    if requirement.mean or requirement.where or requirement.under or not passes(1.0):
        return limit
    low, high = limit, 1.0
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if passes(middle) else (middle, high)
    return high


def _p_counts(fails: NDArray[np.bool_], others: NDArray[np.bool_]) -> float:
    """McNemar's exact test, one-sided: the first fails more often."""
    only_first, only_second = int(np.sum(fails & ~others)), int(np.sum(others & ~fails))
    return float(mcnemar(only_first, only_second, better="a")) if only_first > only_second else 1.0


def _p_means(x: Values, y: Values) -> float:
    """Student's t of the differences, one-sided: the first is larger in the mean. Where flights were lost, who lost more."""
    if np.isinf(x).any() or np.isinf(y).any():
        return _p_counts(np.isinf(x), np.isinf(y))
    d = x - y
    n, mean, deviation = len(d), float(np.mean(d)), float(np.std(d, ddof=1)) if len(d) > 1 else 0.0
    if deviation == 0.0 or n < 2:
        return 1.0
    return float(special.stdtr(n - 1, -mean / (deviation / math.sqrt(n))))
