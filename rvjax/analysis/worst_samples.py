"""Which sample to look at first where a requirement is not shown to hold."""

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
"""What the report orders samples by."""


class _Search:
    """For the worst sample of one requirement, through one table after the other. names: the columns that it needs."""

    def __init__(self, requirement: Requirement, columns: Mapping[str, Column]) -> None:
        self._columns, self._reading = columns, RequirementEvaluator(requirement)
        needed = self._reading.columns(list(columns))
        if not self._reading.of_metric:
            needed += [name for name in _ORDER if name in columns and name not in needed]
        self.names = ["sample", "outcome", *needed]
        bound = requirement.bound
        sign = bound.sign if bound else -1.0
        self._sign = sign if requirement.at_most is None else -sign  # of a metric that is the worse, the larger it is
        self._found: list[pd.DataFrame] = []

    def add(self, frame: pd.DataFrame) -> None:
        """Keeps the worst one of a table."""
        table = frame.iloc[np.flatnonzero(self._reading.chosen(frame))].reset_index(drop=True)
        if not len(table):
            return
        if self._reading.of_metric:
            values = self._reading.values(table, self._columns) * self._sign
            order = int(np.argmax(np.where(np.isnan(values), math.inf, values)))
            value = float(values[order])
            self._found.append(table.iloc[[order]].assign(badness=math.inf if math.isnan(value) else value))
        else:
            self._found.append(table.iloc[worst_first(table, self._columns)[:1]])

    def result(self) -> int | None:
        """Its number."""
        if not self._found:
            return None
        best = pd.concat(self._found, ignore_index=True)
        if self._reading.of_metric:
            best = best.sort_values(["badness", "sample"], ascending=[False, True], ignore_index=True)
            return int(best["sample"].iloc[0])
        return int(best["sample"].iloc[worst_first(best, self._columns)[0]])


def worst_samples(folder: RunFolder, requirements: Sequence[Requirement]) -> list[int | None]:
    """Of each requirement the number of the sample of its class that complies least; None where the class is empty.

    On a metric: one without a number, else the one furthest towards the forbidden side. On the outcome: the first of the
    report's worst samples. Of several, the first. Reads chunk by chunk, once for all requirements.
    """
    if not requirements:
        return []
    columns = folder.columns()
    searches = [_Search(one, columns) for one in requirements]
    for _, frame, _ in folder.some(list(dict.fromkeys(name for one in searches for name in one.names))):
        for one in searches:
            one.add(frame.loc[:, one.names])
    return [one.result() for one in searches]
