"""Which sample to look at first if a requirement does not pass."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd  # pyright: ignore[reportMissingTypeStubs]

from rvjax.analysis.run_totals import SETTLING, worst_first
from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.columns import Column, metric_column

if TYPE_CHECKING:
    from rvjax.campaign import Requirement
    from rvjax.run_folder import RunFolder

_ORDER = ("outcome_time_s", metric_column("window_position_error_m"), metric_column(SETTLING))
"""The columns that the report ranks samples by."""


class _Search:
    """Searches the tables of a run for the worst sample of a requirement. names: the columns it needs."""

    def __init__(self, requirement: Requirement, columns: Mapping[str, Column]) -> None:
        self._columns, self._evaluator = columns, RequirementEvaluator(requirement)
        needed = self._evaluator.columns(list(columns))
        if not self._evaluator.of_metric:
            needed += [name for name in _ORDER if name in columns and name not in needed]
        self.names = ["sample", "outcome", *needed]
        bound = requirement.bound
        sign = bound.sign if bound else -1.0
        self._sign = sign if requirement.at_most is None else -sign  # sign · metric: the larger, the worse
        self._worst: list[pd.DataFrame] = []

    def add(self, frame: pd.DataFrame) -> None:
        """Keeps the worst sample of a table."""
        table = frame.iloc[np.flatnonzero(self._evaluator.chosen(frame))].reset_index(drop=True)
        if not len(table):
            return
        if self._evaluator.of_metric:
            values = self._evaluator.values(table, self._columns) * self._sign
            row = int(np.argmax(np.where(np.isnan(values), math.inf, values)))
            value = float(values[row])
            self._worst.append(table.iloc[[row]].assign(badness=math.inf if math.isnan(value) else value))
        else:
            self._worst.append(table.iloc[worst_first(table, self._columns)[:1]])

    def result(self) -> int | None:
        """The number of the worst sample; None if the class is empty."""
        if not self._worst:
            return None
        worst = pd.concat(self._worst, ignore_index=True)
        if self._evaluator.of_metric:
            worst = worst.sort_values(["badness", "sample"], ascending=[False, True], ignore_index=True)
            return int(worst["sample"].iloc[0])
        return int(worst["sample"].iloc[worst_first(worst, self._columns)[0]])


def worst_samples(folder: RunFolder, requirements: Sequence[Requirement]) -> list[int | None]:
    """For each requirement, the number of the worst sample of its class; None if the class is empty.

    For a metric it is a sample whose value is not a number, otherwise the sample furthest on the wrong side of the bound. For the
    outcome it is the first of the report's worst samples. Ties go to the lowest number. All chunks are read once.
    """
    if not requirements:
        return []
    columns = folder.columns()
    searches = [_Search(requirement, columns) for requirement in requirements]
    for _, frame, _ in folder.some(list(dict.fromkeys(name for search in searches for name in search.names))):
        for search in searches:
            search.add(frame.loc[:, search.names])
    return [search.result() for search in searches]
