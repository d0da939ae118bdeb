"""Which sample to look at first where a requirement is not shown to hold."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd  # pyright: ignore[reportMissingTypeStubs]

from rvjax.check.complying import Reading
from rvjax.totals import SETTLING, worst_first

if TYPE_CHECKING:
    from rvjax.results import RunFolder
    from rvjax.spec import Requirement

_ORDER = ("outcome_time_s", "metric.window_position_error_m", f"metric.{SETTLING}")
"""What the report orders samples by."""


def worst_sample(folder: RunFolder, requirement: Requirement) -> int | None:
    """The number of the sample of the requirement's class that complies least; None where the class is empty.

    On a metric: one without a number, else the one furthest towards the forbidden side. On the outcome: the first of the
    report's worst samples. Of several, the first. Reads chunk by chunk.
    """
    columns, reading = folder.columns(), Reading(requirement)
    needed = reading.columns(list(columns))
    if not reading.of_metric:
        needed += [name for name in _ORDER if name in columns and name not in needed]
    upwards = (requirement.below is not None) != (requirement.at_most is not None)  # larger is worse
    found: list[pd.DataFrame] = []
    for _, frame, _ in folder.some(["sample", "outcome", *needed]):
        table = frame.iloc[np.flatnonzero(reading.chosen(frame))].reset_index(drop=True)
        if not len(table):
            continue
        if reading.of_metric:
            values = reading.values(table, columns) * (1.0 if upwards else -1.0)
            order = int(np.argmax(np.where(np.isnan(values), math.inf, values)))
            value = float(values[order])
            found.append(table.iloc[[order]].assign(badness=math.inf if math.isnan(value) else value))
        else:
            found.append(table.iloc[worst_first(table, columns)[:1]])
    if not found:
        return None
    best = pd.concat(found, ignore_index=True)
    if reading.of_metric:
        best = best.sort_values(["badness", "sample"], ascending=[False, True], ignore_index=True)
        return int(best["sample"].iloc[0])
    return int(best["sample"].iloc[worst_first(best, columns)[0]])
