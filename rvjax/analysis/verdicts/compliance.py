"""Which samples of a table a requirement applies to, the values of their metric, and which of them comply."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd  # pyright: ignore[reportMissingTypeStubs]

from rvjax.columns import DRAW, FAILED, METRIC, Column, draw_column, metric_and_channel, metric_column
from rvjax.errors import UsageError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rvjax.campaign import Requirement
    from rvjax.campaign.bound import Bound
    from rvjax.campaign.requirement import Thinning


ANY = "any"
"""The channel with the worst value."""


class RequirementEvaluator:
    """Evaluates a requirement on tables that have the same columns."""

    def __init__(self, requirement: Requirement) -> None:
        self.requirement = requirement
        self.unit = ""
        self._column: str | None = None

    @property
    def column(self) -> str:
        """The column of its metric; empty for the outcome. Only after a call of `columns`."""
        assert self._column is not None, "call columns() first"
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
        """Whether the requirement is on a metric; otherwise it is on the outcome."""
        return bool(self._column)

    def columns(self, names: Sequence[str]) -> list[str]:
        """The columns it needs besides `sample` and `outcome`. UsageError if a column is not in `names`."""
        self._column = column_of(self.requirement, names)
        law = self._law()
        draws = [draw_column(draw) for draw in dict.fromkeys([*self.requirement.where, *(law.draws if law else ())])]
        for column in draws:
            self._known(column, names)
        return [*([self._column] if self._column else []), *draws]

    def prepare(self, columns: Mapping[str, Column]) -> None:
        """Learns its column and its unit, as from a table with these columns. UsageError as in `columns`."""
        self.columns(list(columns))
        if not self.unit:
            self.unit = columns[self.column].unit if self.column in columns else ""

    def values(self, frame: pd.DataFrame, columns: Mapping[str, Column]) -> NDArray[np.float64]:
        """(n,) values of the metric, NaN if a sample collided or is not finite; for the outcome 1 if captured, otherwise NaN.

        UsageError if the table lacks the metric or the channel.
        """
        if self._column is None:
            self._column = column_of(self.requirement, list(frame.columns))
        if not self.unit:
            self.unit = columns[self._column].unit if self._column in columns else ""
        if not self._column:
            return np.where(frame["outcome"] == "captured", 1.0, math.nan)
        return np.where(frame["outcome"].isin(FAILED), math.nan, np.asarray(frame[self._column], dtype=float))

    def comply(self, values: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(n,) which values comply; NaN never does."""
        if not self._column:
            return values == 1.0
        met = self.bound.met_by(values)
        return ~met & ~np.isnan(values) if self.requirement.at_most is not None else met

    def _known(self, column: str, names: Collection[str]) -> None:
        if column not in names:
            draw = column.removeprefix(DRAW)
            key = "where" if draw in self.requirement.where else f"under {self.requirement.under}"
            raise UsageError(f"{name(self.requirement)}: {key}: no draw {draw!r} in the table; accepted: the name of a draw")

    def _law(self) -> Thinning | None:
        """The law that it is judged under."""
        law = self.requirement.thinning
        if law is None and self.requirement.under is not None:
            start = f"{name(self.requirement)}: under {self.requirement.under}: the law is not known here"
            raise UsageError(f"{start}; accepted: a requirement of a campaign that is loaded with its laws, or of a run folder")
        return law

    def chosen(self, frame: pd.DataFrame) -> NDArray[np.bool_]:
        """(n,) which samples it is judged by: of the law (`under`) and class (`where`). UsageError if the table lacks a draw."""
        return self.kept(frame) & self.of_class(frame)

    def kept(self, frame: pd.DataFrame) -> NDArray[np.bool_]:
        """(n,) which samples are samples of the law that it is judged under; all without one."""
        law = self._law()
        if law is None:
            return np.ones(len(frame), dtype=bool)
        return law.keeps(frame["sample"].to_numpy(dtype=np.int64), self._drawn(law, frame))

    def possible(self, frame: pd.DataFrame) -> NDArray[np.bool_]:
        """(n,) which draws the law and the class have: `chosen` for flights that are no samples."""
        law = self._law()
        return self.of_class(frame) if law is None else self.of_class(frame) & law.possible(self._drawn(law, frame))

    def _drawn(self, law: Thinning, frame: pd.DataFrame) -> dict[str, NDArray[np.float64]]:
        for draw in law.draws:
            self._known(draw_column(draw), list(frame.columns))
        return {draw: np.asarray(frame[draw_column(draw)], dtype=float) for draw in law.draws}

    def of_class(self, frame: pd.DataFrame) -> NDArray[np.bool_]:
        """(n,) which samples are of the class (`where`). UsageError if the table lacks a draw of the class."""
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
    """The column of the metric of a requirement; empty for the outcome. UsageError lists the accepted metrics or channels."""
    metric, channel = requirement.metric, requirement.channel
    if metric == "captured" and channel is None:
        return ""
    start = metric_column(metric)
    known = [metric_and_channel(column.removeprefix(METRIC)) for column in columns if column.startswith(METRIC)]
    channels = [known_channel for metric_name, known_channel in known if metric_name == metric and known_channel]
    if channel is None and start in columns:
        return start
    if (channel or ANY) in channels:
        return f"{start}.{channel or ANY}"
    if start not in columns and not channels:
        metrics = sorted({"captured", *(metric_name for metric_name, _ in known)})
        raise UsageError(f"{name(requirement)}: metric {metric!r} is not in the table; accepted: {', '.join(metrics)}")
    accepted = ", ".join(channels) or "none, this metric has no channels"
    raise UsageError(f"{name(requirement)}: {metric} has no channel {channel or ANY!r}; accepted: {accepted}")


def name(requirement: Requirement) -> str:
    """The name of the requirement, or its metric and channel."""
    channel = f" ({requirement.channel})" if requirement.channel else ""
    return requirement.name or requirement.metric + channel


def complies(requirement: Requirement, frame: pd.DataFrame) -> NDArray[np.bool_]:
    """(n,) which samples of a table comply with a requirement on a share, or are not of its class and law.

    UsageError if the table lacks the metric, the channel, or a draw of the class.
    """
    evaluator = RequirementEvaluator(requirement)
    return evaluator.comply(evaluator.values(frame, {})) | ~evaluator.chosen(frame)
