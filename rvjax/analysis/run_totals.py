"""Totals: what the report and the verdicts need of the samples, accumulated chunk by chunk in bounded memory.

Totals keep counts, extremes, sketches of distributions, and a few whole rows, which are chosen by their contents or their
numbers. So the order of the chunks does not matter, and ten million samples take no more memory than twenty thousand. A value
that is not a number counts as the worst value.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.analysis.ledger import Ledger
from rvjax.campaign import Keep
from rvjax.columns import Column, metric_column
from rvjax.run_folder import Account
from rvjax.run_folder.named_arrays import Record
from rvjax.stats import quantile_rank
from rvjax.stats.quantile_sketch import Sketch

HEAD = 25
"""The number of first chunks whose samples are kept whole; their draws are as random as all others."""

AT_ONCE = 40
"""Chunks that are added to the sketches together, since a sketch adds many numbers nearly as fast as few."""

WORST = 10
"""The number of worst samples that are kept whole; more if the campaign keeps more of their flights."""

FAILURES = 2_048
"""The largest number of failed samples behind the first chunks that are kept whole: those with the smallest numbers."""

PERCENTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Percentiles of the settling time whose flights a campaign may keep."""

SETTLING = "settling_time_s"

_RANK = {"not_finite": 0, "collided": 1, "not_settled": 2, "captured": 3}


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
        self._failures: list[pd.DataFrame] = []
        self._waiting: list[pd.DataFrame] = []

    def add(self, chunk: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Adds the table of a chunk; the table must not be changed afterwards.

        FolderError if its columns differ from the other chunks, or if the chunk or any of its samples was added before.
        """
        self._ledger.add(chunk, frame, columns)
        if chunk < HEAD:
            self._head.append(frame)
        else:
            self._keep_failures([frame.iloc[np.flatnonzero(frame["outcome"] != "captured")]])
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
        worst = frame.iloc[worst_first(frame, self.columns)[: self._most]]
        self._keep_worst(worst)

    @property
    def _most(self) -> int:
        """The number of worst samples that are kept."""
        return max(WORST, self.keep.worst)

    def _keep_worst(self, rows: pd.DataFrame) -> None:
        """Adds rows to the worst samples, and keeps the worst of all."""
        worst = pd.concat([self._worst, rows], ignore_index=True) if len(self._worst) else rows
        self._worst = worst.iloc[worst_first(worst, self.columns)[: self._most]].reset_index(drop=True)

    def _keep_failures(self, frames: Iterable[pd.DataFrame]) -> None:
        """Adds failed samples, and keeps those with the smallest numbers."""
        self._failures += [frame for frame in frames if len(frame)]
        if sum(map(len, self._failures)) > 2 * FAILURES:
            self._failures = [self.failures]

    def merge(self, other: Totals) -> None:
        """Adds the samples of other totals, which must not be changed afterwards. The result is the same, bit for bit, as if all
        chunks had been added here. Errors as in `add`; then nothing has changed. ValueError if the others keep other flights.
        """
        if other.keep != self.keep:
            raise ValueError(f"totals that keep {other.keep} cannot be merged into totals that keep {self.keep}")
        self._ledger.merge(other._ledger)
        self._take_in()
        other._take_in()
        for path, sketch in other._sketches.items():
            self._sketches.setdefault(path, Sketch()).merge(sketch)
        for path, (low, high) in other._reach.items():
            mine = self._reach.get(path, (math.inf, -math.inf))
            self._reach[path] = min(mine[0], low), max(mine[1], high)
        self._lost.merge(other._lost)
        self._failed += other._failed
        self._head += other._head
        self._keep_failures(other._failures)
        if len(other._worst):
            self._keep_worst(other._worst)

    def record(self) -> Record:
        """All of it, for `Totals.of`. Equal totals give equal records, in whatever order their chunks came."""
        sketches = {str(place): Record.of_numbers(sketch.arrays()) for place, sketch in enumerate(self.metrics.values())}
        low, high = (np.array([ends[side] for ends in self.reach.values()], np.float64) for side in (0, 1))
        parts = {
            "ledger": self._ledger.record(),
            "metrics": Record.joined(sketches, names=list(self.metrics)),
            "reach": Record.of_numbers({"low": low, "high": high}, names=list(self.reach)),
            "lost": Record.of_numbers(self.lost.arrays()),
            "failed": Record.of_numbers({"sample": self.failed}),
            "worst": Record.of_frame(self.worst),
            "head": Record.of_frame(self.head),
            "failures": Record.of_frame(self.failures),
        }
        return Record.joined(parts)

    @classmethod
    def of(cls, record: Record, keep: Keep | None = None) -> Totals:
        """The totals of a record. ValueError, KeyError or TypeError if the record contradicts itself."""
        totals = cls(keep)
        totals._ledger = Ledger.of(record.part("ledger"))
        metrics, reach = record.part("metrics"), record.part("reach")
        for place, name in enumerate(metrics.document["names"]):
            totals._sketches[name] = sketch_of(metrics.part(str(place)))
        ends = zip(*(reach.numbers(side, np.float64).tolist() for side in ("low", "high")), strict=True)
        totals._reach = dict(zip(reach.document["names"], ends, strict=True))
        totals._lost = sketch_of(record.part("lost"))
        totals._failed = [record.part("failed").numbers("sample")]
        totals._worst, head = record.part("worst").frame(), record.part("head").frame()
        totals._head = [head] if len(head) else []
        totals._keep_failures([record.part("failures").frame()])
        if any(sketch.n != totals.n for sketch in totals._sketches.values()):
            raise ValueError(f"a metric of another number of samples than {totals.n}")
        uncaptured = totals.n - totals.counts["captured"] if totals.keep.failed else 0
        if totals._failed[0].size != uncaptured:
            raise ValueError(f"{totals._failed[0].size} failed samples are kept, where {uncaptured} failed")
        if len(totals._worst) != min(totals.n, totals._most):
            raise ValueError(f"{len(totals._worst)} worst samples of {totals.n}, where {totals._most} are kept")
        return totals

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
    def failures(self) -> pd.DataFrame:
        """The rows of the failed samples behind the first chunks, in the order of the samples, at most `FAILURES`."""
        if not self._failures:
            return self.worst.iloc[:0]
        rows = pd.concat(self._failures, ignore_index=True) if len(self._failures) > 1 else self._failures[0]
        return rows.sort_values("sample", ignore_index=True).iloc[:FAILURES]

    @property
    def failed(self) -> NDArray[np.int64]:
        """The numbers of all samples that are not captured, ascending; empty unless `keep.failed`."""
        self._take_in()
        return np.sort(np.concatenate([np.empty(0, np.int64), *self._failed]))

    @property
    def samples(self) -> Sequence[int]:
        """The numbers of all samples, ascending."""
        return self._ledger.samples()

    def __contains__(self, chunk: int) -> bool:
        """Whether a chunk was added."""
        return chunk in self._ledger

    @property
    def chunks(self) -> Sequence[int]:
        """The numbers of the chunks that were added, ascending."""
        return self._ledger.chunks

    @property
    def firsts(self) -> Sequence[int]:
        """The first samples of these chunks, ascending."""
        return self._ledger.firsts

    def account(self, requested: int) -> Account:
        """The outcomes of the requested samples, and how many are missing. FolderError if a sample was never requested."""
        return self._ledger.account(requested)


def sketch_of(record: Record) -> Sketch:
    """The sketch whose `arrays` a record has; ValueError if they contradict each other."""
    return Sketch.of(**{name: record.numbers(name, dtype) for name, dtype in Sketch.TYPES.items()})


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

    Not finite samples come first, then those that collided, each in the order of their times; then not settled ones by the
    largest position error over the closing window; then captured ones by settling time. Ties go by sample number.
    """
    rank = np.array([_RANK.get(str(outcome), 0) for outcome in frame["outcome"]])
    keys = pd.DataFrame({"class": rank, "sample": frame["sample"].to_numpy()})
    for key, name in (("window", "window_position_error_m"), ("settling", SETTLING)):
        keys[key] = -metric(frame, name, columns) if metric_column(name) in frame else 0.0
    time = frame["outcome_time_s"].to_numpy() if "outcome_time_s" in frame else 0.0
    keys["time"] = np.where(rank <= _RANK["collided"], time, 0.0)
    keys["window"] = keys["window"].where(rank == _RANK["not_settled"], 0.0)
    return keys.sort_values(["class", "time", "window", "settling", "sample"], kind="stable").index.tolist()


def metric(frame: pd.DataFrame, name: str, columns: Mapping[str, Column]) -> NDArray[np.float64]:
    """(n,) values of a metric in SI. NaN, the value of a not finite sample, is replaced by the worst value."""
    values = frame[metric_column(name)].to_numpy(dtype=float)
    return np.where(np.isnan(values), worst_value(columns.get(metric_column(name))), values)


def worst_value(column: Column | None) -> float:
    """The worst value of a metric: -inf if higher is better, otherwise +inf."""
    return -math.inf if column is not None and column.better == "higher" else math.inf
