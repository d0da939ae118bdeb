"""Which samples of a table a requirement is about, what their metric is, and which of them comply."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd  # pyright: ignore[reportMissingTypeStubs]

from rvjax.columns import DRAW, METRIC, Column, draw_column, metric_and_channel, metric_column
from rvjax.errors import UsageError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rvjax.campaign import Requirement
    from rvjax.campaign.bound import Bound


ANY = "any"
"""The worst channel."""


class RequirementEvaluator:
    """Reads a requirement's numbers from tables of the same columns."""

    def __init__(self, requirement: Requirement) -> None:
        self.requirement = requirement
        self.unit = ""
        self._column: str | None = None

    @property
    def column(self) -> str:
        """The column that it is on; empty for the outcome. To be asked after `columns`."""
        assert self._column is not None, "it has not seen the columns yet"
        return self._column

    @property
    def bound(self) -> Bound:
        """The bound on the metric. UsageError where the requirement has none."""
        bound = self.requirement.bound
        if bound is None:
            start = f"{name(self.requirement)}: nothing to compare {self.requirement.metric} with"
            raise UsageError(f"{start}; accepted: below or above")
        return bound

    @property
    def of_metric(self) -> bool:
        """Whether it is on a metric; else on the outcome."""
        return bool(self._column)

    def columns(self, names: Sequence[str]) -> list[str]:
        """The columns that it needs besides `sample` and `outcome`; UsageError where they are not among these."""
        self._column = column_of(self.requirement, names)
        draws = [draw_column(draw) for draw in self.requirement.where]
        for column in draws:
            self._known(column, names)
        return [*([self._column] if self._column else []), *draws]

    def values(self, frame: pd.DataFrame, columns: Mapping[str, Column]) -> NDArray[np.float64]:
        """(n,) The metric of the samples of the class, NaN where one is not finite; of the outcome 1 where captured.

        UsageError where the table lacks the metric or the channel.
        """
        if self._column is None:
            self._column = column_of(self.requirement, list(frame.columns))
        if not self.unit:
            self.unit = columns[self._column].unit if self._column in columns else ""
        if not self._column:
            return np.where(frame["outcome"] == "captured", 1.0, math.nan)
        return np.where(frame["outcome"] != "not_finite", np.asarray(frame[self._column], dtype=float), math.nan)

    def comply(self, values: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which values comply (NaN never does)."""
        if not self._column:
            return values == 1.0
        met = self.bound.met_by(values)
        return ~met & ~np.isnan(values) if self.requirement.at_most is not None else met

    def _known(self, column: str, names: Collection[str]) -> None:
        if column not in names:
            draw = column.removeprefix(DRAW)
            raise UsageError(f"{name(self.requirement)}: where: no draw {draw!r} in the table; accepted: the name of a draw")

    def chosen(self, frame: pd.DataFrame) -> NDArray[np.bool_]:
        """(n,) Whether a sample is of the class. UsageError where the table lacks a draw of it."""
        chosen = np.ones(len(frame), dtype=bool)
        for draw, condition in self.requirement.where.items():
            column = draw_column(draw)
            self._known(column, list(frame.columns))
            x = np.asarray(frame[column], dtype=float)
            for bound, holds in (
                (condition.below, np.less),
                (condition.at_least, np.greater_equal),
                (condition.equals, np.equal),
            ):
                if bound is not None:
                    chosen &= holds(x, bound)
        return chosen


def column_of(requirement: Requirement, columns: Sequence[str]) -> str:
    """The column that a requirement is on; empty for the outcome. UsageError names what there is."""
    metric, channel = requirement.metric, requirement.channel
    if metric == "captured" and channel is None:
        return ""
    start = metric_column(metric)
    known = [metric_and_channel(one.removeprefix(METRIC)) for one in columns if one.startswith(METRIC)]
    channels = [own for metric_name, own in known if metric_name == metric and own]
    if channel is None and start in columns:
        return start
    if (channel or ANY) in channels:
        return f"{start}.{channel or ANY}"
    if start not in columns and not channels:
        metrics = sorted({"captured", *(metric_name for metric_name, _ in known)})
        raise UsageError(f"{name(requirement)}: metric {metric!r} is not in the table; accepted: {', '.join(metrics)}")
    accepted = ", ".join(channels) or "none, it has one value for all"
    raise UsageError(f"{name(requirement)}: {metric} has no channel {channel or ANY!r}; accepted: {accepted}")


def name(requirement: Requirement) -> str:
    """The requirement's own name, or its metric and channel."""
    channel = f" ({requirement.channel})" if requirement.channel else ""
    return requirement.name or requirement.metric + channel


def complies(requirement: Requirement, frame: pd.DataFrame) -> NDArray[np.bool_]:
    """(n,) which samples of a table comply with a requirement on a share, or are not of its class.

    UsageError where the table lacks the metric, the channel, or a draw of the class.
    """
    reading = RequirementEvaluator(requirement)
    return reading.comply(reading.values(frame, {})) | ~reading.chosen(frame)
