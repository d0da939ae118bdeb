"""Totals: what the report and the verdicts need of the samples, accumulated chunk by chunk in bounded memory.

Totals keep counts, extremes, sketches of distributions, and a few whole rows, which are chosen by their contents or their
numbers. So the order of the chunks does not matter, and ten million samples take no more memory than twenty thousand. A value
that is not a number counts as the worst value.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.campaign import Keep
from rvjax.columns import Column, metric_column
from rvjax.errors import FolderError
from rvjax.run_folder import OUTCOMES, Account
from rvjax.stats import quantile_rank
from rvjax.stats.quantile_sketch import Sketch

HEAD = 25
"""The number of first chunks whose samples are kept whole; their draws are as random as all others."""

AT_ONCE = 40
"""Chunks that are added to the sketches together, since a sketch adds many numbers nearly as fast as few."""

WORST = 10
"""The number of worst samples that are kept whole; more if the campaign keeps more of their flights."""

PERCENTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Percentiles of the settling time whose flights a campaign may keep."""

SETTLING = "settling_time_s"

_RANK = {"not_finite": 0, "not_settled": 1, "captured": 2}


class Ledger:
    """The samples that were added, and their outcomes. Every sample is there once, and all chunks have the same columns."""

    def __init__(self) -> None:
        self.columns: dict[str, Column] = {}
        self.counts: dict[str, int] = dict.fromkeys(OUTCOMES, 0)
        self.n = 0
        self._chunks: dict[int, None] = {}
        self._spans: list[tuple[int, int]] = []

    def add(self, chunk: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Enters the samples of a chunk.

        FolderError if its columns differ from the other chunks, or if the chunk or any of its samples was entered before.
        """
        sample = frame["sample"].to_numpy()
        if not sample.size or sample[0] < 0 or not np.array_equal(sample, sample[0] + np.arange(sample.size)):
            raise FolderError(f"chunk {chunk}: its samples are not consecutive numbers from 0 on; fly the campaign again")
        if self._chunks:
            self._compare(chunk, columns)
        first, behind = int(sample[0]), int(sample[-1]) + 1
        place = bisect_left(self._spans, (first, behind))
        neighbours = self._spans[max(place - 1, 0) : place + 1]
        if chunk in self._chunks or any(first < end and start < behind for start, end in neighbours):
            raise FolderError(
                f"chunk {chunk}: the chunk, or a sample from {first} to {behind - 1}, is there twice; "
                "fly the campaign again with another --out"
            )
        self.columns = self.columns or dict(columns)
        self._chunks[chunk] = None
        self._spans.insert(place, (first, behind))
        self.n += sample.size
        for outcome, count in frame["outcome"].value_counts().items():
            self.counts[str(outcome)] = self.counts.get(str(outcome), 0) + int(count)

    def _compare(self, chunk: int, columns: Mapping[str, Column]) -> None:
        if columns != self.columns:
            odd = sorted(key for key in columns.keys() | self.columns if columns.get(key) != self.columns.get(key))
            advice = "fly the campaign again"
            first = next(iter(self._chunks))
            raise FolderError(f"chunk {chunk}: other columns than in chunk {first}: {', '.join(odd)}; {advice}")

    def samples(self) -> Sequence[int]:
        """The numbers of all samples, ascending."""
        if self._spans and self._spans[-1][1] == self.n:
            return range(self.n)
        return [sample for first, behind in self._spans for sample in range(first, behind)]

    def account(self, requested: int) -> Account:
        """The outcomes of the requested samples, and how many are missing. FolderError if a sample was never requested."""
        if self._spans and self._spans[-1][1] > requested:
            raise FolderError(
                f"chunk with sample {self._spans[-1][1] - 1}: only {requested} samples were requested; "
                "fly the campaign again with another --out"
            )
        captured, not_settled, not_finite = (self.counts[outcome] for outcome in OUTCOMES)
        return Account(requested, captured, not_settled, not_finite, requested - self.n)


class Totals:
    """The totals of a run. keep: the flights that the campaign keeps; it decides which samples are remembered."""

    def __init__(self, keep: Keep | None = None) -> None:
        self.keep = keep or Keep()
        self._ledger = Ledger()
        self._sketches: dict[str, Sketch] = {}
        self._reach: dict[str, tuple[float, float]] = {}
        self._lost = Sketch()
        self._worst = pd.DataFrame()
        self._head: list[pd.DataFrame] = []
        self._failed: list[NDArray[np.int64]] = []
        self._waiting: list[pd.DataFrame] = []

    def add(self, chunk: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Adds the table of a chunk; the table must not be changed afterwards.

        FolderError if its columns differ from the other chunks, or if the chunk or any of its samples was added before.
        """
        self._ledger.add(chunk, frame, columns)
        if chunk < HEAD:
            self._head.append(frame)
        self._waiting.append(frame)
        if len(self._waiting) >= AT_ONCE:
            self._take_in()

    def _take_in(self) -> None:
        """Adds the waiting tables to the totals."""
        if not self._waiting:
            return
        frame = pd.concat(self._waiting, ignore_index=True)
        self._waiting = []
        for name in frame.columns:
            kind, _, path = str(name).partition(".")
            if kind == "metric":
                self._sketches.setdefault(path, Sketch()).add(metric(frame, path, self.columns))
            elif kind == "draw" and pd.api.types.is_numeric_dtype(frame[name]):
                drawn = frame[name].to_numpy(dtype=float)
                low, high = self._reach.get(path, (math.inf, -math.inf))
                finite = drawn[drawn < math.inf]  # the onset of a fault that never begins is inf
                low, high = finite.min(initial=low), finite.max(initial=high)
                self._reach[path] = float(low) + 0.0, float(high) + 0.0  # + 0.0 turns −0.0 into 0.0
        if "outcome_time_s" in frame:
            lost = frame.loc[frame["outcome"] == "not_finite", "outcome_time_s"].to_numpy(dtype=float)
            self._lost.add(np.where(np.isnan(lost), math.inf, lost))
        if self.keep.failed:
            self._failed.append(frame.loc[frame["outcome"] != "captured", "sample"].to_numpy(dtype=np.int64))
        most = max(WORST, self.keep.worst)
        worst = frame.iloc[worst_first(frame, self.columns)[:most]]
        worst = pd.concat([self._worst, worst], ignore_index=True) if len(self._worst) else worst
        self._worst = worst.iloc[worst_first(worst, self.columns)[:most]].reset_index(drop=True)

    @property
    def n(self) -> int:
        """The number of samples."""
        return self._ledger.n

    @property
    def columns(self) -> dict[str, Column]:
        """Unit and description of every column."""
        return self._ledger.columns

    @property
    def counts(self) -> dict[str, int]:
        """The number of samples by outcome."""
        return self._ledger.counts

    @property
    def metrics(self) -> dict[str, Sketch]:
        """The distribution of every metric, by its name without `metric.`, in column order."""
        self._take_in()
        return self._sketches

    @property
    def reach(self) -> dict[str, tuple[float, float]]:
        """Smallest and largest finite value of every numeric draw, by its path, in column order; (+∞, −∞) if none is finite."""
        self._take_in()
        return self._reach

    @property
    def lost(self) -> Sketch:
        """The times at which the not finite samples ended, in s."""
        self._take_in()
        return self._lost

    @property
    def worst(self) -> pd.DataFrame:
        """The rows of the worst samples, the worst first."""
        self._take_in()
        return self._worst

    @property
    def head(self) -> pd.DataFrame:
        """The rows of the first chunks in the order of the samples; empty if none of these chunks was added."""
        if not self._head:
            return self.worst.iloc[:0]
        return pd.concat(self._head, ignore_index=True).sort_values("sample", ignore_index=True)

    @property
    def failed(self) -> NDArray[np.int64]:
        """The numbers of all samples that are not captured, ascending; empty unless `keep.failed`."""
        self._take_in()
        return np.sort(np.concatenate([np.empty(0, np.int64), *self._failed]))

    @property
    def samples(self) -> Sequence[int]:
        """The numbers of all samples, ascending."""
        return self._ledger.samples()

    def account(self, requested: int) -> Account:
        """The outcomes of the requested samples, and how many are missing. FolderError if a sample was never requested."""
        return self._ledger.account(requested)


def wanted(totals: Totals) -> Sequence[int]:
    """The samples whose flights `totals.keep` keeps, ascending."""
    keep, head = totals.keep, totals.head
    if keep.all:
        return totals.samples
    samples = {*totals.worst["sample"].iloc[: keep.worst].tolist()} if totals.n else set[int]()
    samples.update(totals.failed.tolist())
    if keep.percentiles and len(head) and SETTLING in totals.metrics:
        order = np.argsort(metric(head, SETTLING, totals.columns), kind="stable")
        rows = [order[quantile_rank(len(head), q)] for q in PERCENTILES]
        samples.update(head["sample"].iloc[rows].tolist())
    return sorted(samples)


def worst_first(frame: pd.DataFrame, columns: Mapping[str, Column]) -> list[int]:
    """The row indices of a table from the worst sample to the best.

    Not finite samples come first, in the order of their times; then not settled ones by the largest position error over the
    closing window; then captured ones by settling time. Ties go by sample number.
    """
    rank = np.array([_RANK.get(str(outcome), 0) for outcome in frame["outcome"]])
    keys = pd.DataFrame({"class": rank, "sample": frame["sample"].to_numpy()})
    for key, name in (("window", "window_position_error_m"), ("settling", SETTLING)):
        keys[key] = -metric(frame, name, columns) if metric_column(name) in frame else 0.0
    time = frame["outcome_time_s"].to_numpy() if "outcome_time_s" in frame else 0.0
    keys["time"] = np.where(rank == 0, time, 0.0)
    keys["window"] = keys["window"].where(rank == 1, 0.0)
    return keys.sort_values(["class", "time", "window", "settling", "sample"], kind="stable").index.tolist()


def metric(frame: pd.DataFrame, name: str, columns: Mapping[str, Column]) -> NDArray[np.float64]:
    """(n,) values of a metric in SI. NaN, the value of a not finite sample, is replaced by the worst value."""
    values = frame[metric_column(name)].to_numpy(dtype=float)
    return np.where(np.isnan(values), worst_value(columns.get(metric_column(name))), values)


def worst_value(column: Column | None) -> float:
    """The worst value of a metric: -inf if higher is better, otherwise +inf."""
    return -math.inf if column is not None and column.better == "higher" else math.inf
